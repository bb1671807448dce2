//! The fits of one call: a first one, and others to what it tells of masks and points.

use super::run::Run;
use super::view::View;
use super::{BYTES_OF_FIT, FitResult, Fitted, Fitter, Flags, Last, MadeWith, body, describe, fit, outline};
use crate::error::{Result, cancelled_if, unless_cancelled};
use crate::geometry::Cylinder;
use crate::memory::List;

impl Fitter {
    /// The fit of a call, in the memory that the fitter lends.
    pub(super) fn fit_in_memory(&mut self, run: &mut Run<'_>) -> Result<FitResult> {
        self.check_memory(BYTES_OF_FIT)?;
        let ends_with_depth = self.options.is_robust() && self.views.iter().any(View::mask_ends_with_depth);
        let fit = match self.fit_among_pixels(run)? {
            Some(fit) => fit,
            None => self.fit_as_pushed(ends_with_depth, run)?,
        };
        let Fitted { made_with, mut result, last } = fit;
        result.flags.set(Flags::MASK_ENDS_WITH_DEPTH, ends_with_depth);
        result.seconds.total = run.seconds();
        self.made_with = Some(made_with);
        self.result = Some(result);
        self.last = Some(last);
        Ok(result)
    }

    /// The fit to all points of the views, or to those of their masks.
    pub(super) fn fit_as_pushed(&self, ends_with_depth: bool, run: &mut Run<'_>) -> Result<Fitted> {
        match self.fit_by_outline(run)? {
            Some(fit) => Ok(fit),
            None if ends_with_depth => {
                let first = self.fit_views(List::new(), run)?;
                self.fit_to_drawn(first, &[], run)
            }
            None => {
                let first = match unless_cancelled(self.fit_views(List::new(), run))? {
                    Ok(first) => Ok(self.fit_to_one_radius_in_masks(first, run)?),
                    Err(error) => Err(error),
                };
                self.fit_to_body(first, run)
            }
        }
    }

    /// The fit of the views, of which those without a mask have that of their points. `None` where there are none, and where the fit is poor,
    /// as the points may be anything, or locates no limb: then their outline alone would tell the radius.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn fit_by_outline(&self, run: &mut Run<'_>) -> Result<Option<Fitted>> {
        let masked = self.with_masks_of_points();
        if masked.is_empty() {
            return Ok(None);
        }
        let is_good =
            |fit: &Fitted| fit.result.limbs_located > 0 && !fit.result.flags.contains(Flags::POOR_FIT);
        let first = unless_cancelled(self.fit_views(masked.clone(), run))?;
        let Some(first) = first.ok().filter(is_good) else { return Ok(None) };
        Ok(Some(self.fit_to_drawn(first, &masked, run)?).filter(is_good))
    }

    /// The fits after a first one, to sides that are drawn about the one before; `masked` are views with a mask of their points.
    #[inline(never)] // Not inlined: its locals would enlarge the caller's stack frame.
    fn fit_to_drawn(&self, mut fit: Fitted, masked: &[Option<View>], run: &mut Run<'_>) -> Result<Fitted> {
        for factor in outline::RADII {
            run.check()?;
            let drawn = self.drawn_again(masked, &fit.result.cylinder, factor);
            if drawn.iter().all(Option::is_none) {
                break;
            }
            let Ok(again) = unless_cancelled(self.fit_views(drawn, run))? else { break };
            fit = again;
        }
        Ok(fit)
    }

    /// A fit of the views, of which some are `drawn` again.
    pub(super) fn fit_views(&self, drawn: List<Option<View>>, run: &mut Run<'_>) -> Result<Fitted> {
        let began = run.seconds();
        let separated = self.separated(drawn, run)?;
        let known: List<_> = separated.iter().map(|view| (view.of_limbs, view.whole)).collect();
        run.check()?;
        let bodies: List<_> = separated.into_iter().map(|view| view.body).collect();
        let mut data = self.data_of(&bodies)?;
        data.last = self.continued();
        for view in &mut data.views {
            if let Some(&(of_limbs, whole)) = known.get(view.index) {
                (view.of_limbs, view.whole) = (of_limbs, whole && data.last.is_some());
            }
        }
        cancelled_if(run.report_again().is_break())?;
        let mut started = began;
        let fit = fit::fit(&data, run, |seconds| started = seconds)?;
        let ended = run.seconds();
        // Of very many points a description takes as long as several steps.
        run.check()?;
        let mut result =
            describe::describe(&data, &fit.constraints, &fit.start, &fit.cylinder, fit.scales.as_ref())?;
        if let Some(convergence) = &fit.convergence {
            result.add_convergence(convergence);
            result.seconds.start = started - began;
            result.seconds.solve = ended - started;
        }
        let last = Last::new(&fit);
        Ok(Fitted { made_with: MadeWith { constraints: fit.constraints, bodies }, result, last })
    }

    /// By view: the view with its points as a mask, where it has none. Empty where no view has to be changed, and for the other
    /// objectives, which take the views as they are.
    fn with_masks_of_points(&self) -> List<Option<View>> {
        if !self.options.is_robust() {
            return List::new();
        }
        let masked: List<_> = self.views.iter().map(View::with_mask_of_points).collect();
        if masked.iter().any(Option::is_some) { masked } else { List::new() }
    }

    /// By view: the view with the sides of its mask drawn again about a cylinder, where the mask ends with the depth.
    fn drawn_again(&self, masked: &[Option<View>], cylinder: &Cylinder, factor: f64) -> List<Option<View>> {
        let again = |view: &View| {
            let needed = view.image().is_some() && view.mask_ends_with_depth();
            needed.then(|| view.with_sides_of(&view.seen(cylinder), factor)).flatten()
        };
        self.views_or(masked).map(again).collect()
    }

    /// By view: what is fitted of it where that is not the view as it was pushed: the part of it that is the body, where
    /// its mask holds more, the view that was drawn again, or the one without points that are far from all others, each without
    /// those next to something in front.
    fn separated(&self, drawn: List<Option<View>>, run: &mut Run<'_>) -> Result<List<body::Separated>> {
        // The other objectives take the mask as it is.
        if !self.options.is_robust() {
            return Ok(List::new());
        }
        let start = self.known_cylinder();
        let mut drawn = drawn.into_iter();
        let body = |view: &View| {
            run.check()?;
            let drawn = drawn.next().flatten().or_else(|| view.without_far_points());
            let separated = body::separate(drawn.as_ref().unwrap_or(view), &self.options, start, run)?;
            let body = separated.body.or(drawn);
            let clear = body.as_ref().unwrap_or(view).without_points_beside_cover(&self.options.noise);
            Ok(body::Separated { body: clear.or(body), ..separated })
        };
        self.views.iter().map(body).collect()
    }
}
