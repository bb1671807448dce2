//! Calls that apply a cylinder: completion, extent, choice of edges.

use crate::call;
use crate::calls::{Case, Teller};
use crate::checks;
use cylfuse::ffi::*;

impl Case<'_> {
    pub fn apply(&mut self) {
        let fitter = self.fitter();
        let t = Teller::Fitter(fitter);
        let (model, mask) = (self.source.model_or_last(), self.source.mask_or_none());
        match self.source.dice.below(4) {
            0 => self.complete(fitter, model, mask),
            1 => self.complete_depth(fitter, model, mask),
            2 => {
                let out = self.source.output();
                if call!(self, t, cylfuse_fitter_extent(fitter, model, mask, out.pointer)) && out.is_whole() {
                    checks::extent(&out.read().unwrap());
                }
            }
            _ => {
                let (segments, count) = self.source.segments();
                let reach = self.source.number(3.0);
                let room = self.source.room::<u8>(count.min(100));
                let capacity = count.min(100);
                call!(
                    self,
                    t,
                    cylfuse_fitter_select_edges(fitter, model, segments, reach, room.pointer, capacity)
                );
            }
        }
    }

    fn complete(
        &mut self,
        fitter: *mut cylfuse_fitter,
        model: *const cylfuse_cylinder,
        mask: *const cylfuse_mask_view,
    ) {
        let t = Teller::Fitter(fitter);
        let layout = cylfuse_layout(self.source.constant(1));
        let bound = self.source.room::<usize>(1);
        if !call!(self, t, cylfuse_fitter_complete_bound(fitter, mask, layout, bound.pointer)) {
            return;
        }
        let bound = bound.read().unwrap();
        // Intrinsics of many pixels may have been set; a program with less room is told so.
        let capacity = bound.min(30_000);
        let capacity = if self.source.strikes() { capacity / 2 } else { capacity };
        let wide = self.source.dice.one_in(2);
        let size = if wide { 24 } else { 12 };
        let room = self.source.room::<u8>(capacity * size);
        let value = cylfuse_points_out {
            struct_size: 0,
            scalar: cylfuse_scalar(if wide { 2 } else { 1 }),
            data: room.pointer.cast(),
            capacity,
            point_stride: 0,
            row_stride: 0,
        };
        let out = self.source.input(&value);
        let completion = self.source.output();
        if call!(self, t, cylfuse_fitter_complete(fitter, model, mask, layout, out, completion.pointer)) {
            let completion: cylfuse_completion = completion.read().unwrap();
            let count = if layout == cylfuse_layout(0) { completion.count as usize } else { bound };
            for k in 0..count * 3 {
                let number = unsafe {
                    if wide {
                        room.pointer.cast::<f64>().add(k).read_unaligned()
                    } else {
                        room.pointer.cast::<f32>().add(k).read_unaligned().into()
                    }
                };
                let allowed = number.is_finite() || (number.is_nan() && layout == cylfuse_layout(1));
                assert!(allowed, "a completed point has {number}");
            }
        }
    }

    fn complete_depth(
        &mut self,
        fitter: *mut cylfuse_fitter,
        model: *const cylfuse_cylinder,
        mask: *const cylfuse_mask_view,
    ) {
        let (width, height) = self.source.view.size;
        let narrow = self.source.dice.one_in(2);
        let size = if narrow { 2 } else { 4 };
        let room = self.source.room::<u8>(width * height * size);
        let value = cylfuse_depth_out {
            struct_size: 0,
            format: cylfuse_depth_format(if narrow { 1 } else { 2 }),
            data: room.pointer.cast(),
            width: width as u32,
            height: height as u32,
            row_stride: 0,
            pixel_stride: 0,
            scale: self.source.number(if narrow { 0.001 } else { 1.0 }),
        };
        let out = self.source.input(&value);
        let completion = self.source.output::<cylfuse_completion>();
        let t = Teller::Fitter(fitter);
        if call!(self, t, cylfuse_fitter_complete_depth(fitter, model, mask, out, completion.pointer))
            && !narrow
        {
            for k in 0..width * height {
                let depth = unsafe { room.pointer.cast::<f32>().add(k).read_unaligned() };
                assert!(depth.is_finite() && depth >= 0.0, "a completed depth is {depth}");
            }
        }
    }
}
