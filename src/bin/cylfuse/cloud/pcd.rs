//! PCD, the format of the Point Cloud Library, version 0.7: ASCII, binary and compressed.
//!
//! Written here because the one crate for it (`pcd-rs` 0.13) indexes out of bounds on damaged compressed
//! files, takes memory on the word of the header, and allocates for every point.

use super::{Cloud, CloudFile, little_endian};
use std::io::Write;

/// The most that one byte of LZF stands for: a reference of 3 bytes copies at most 264.
const LZF_MAX_RATIO: usize = 88;

/// A number of a point.
#[derive(Debug, Clone, Copy)]
struct Field {
    /// F, I or U.
    kind: char,
    /// Bytes of a number.
    size: usize,
    /// Where it starts in a point, in bytes.
    offset: usize,
    /// Which column it is in text.
    column: usize,
}

#[derive(Debug)]
struct Header {
    axes: [Field; 3],
    points: usize,
    /// The columns of the grid that WIDTH and HEIGHT tell, where it has all points and more than a row.
    columns_of_grid: Option<usize>,
    point_size: usize,
    columns: usize,
    data: String,
    /// Where the data start in the file.
    end: usize,
}

/// Reads the points of a PCD file.
pub fn parse(bytes: &[u8]) -> Result<CloudFile, String> {
    let header = Header::parse(bytes)?;
    let body = &bytes[header.end..];
    let points = match header.data.as_str() {
        "ascii" => header.ascii(body)?,
        "binary" => {
            let body = header.take(body, "binary data")?;
            header.points(body, |field, index| index * header.point_size + field.offset)
        }
        "binary_compressed" => {
            let body = header.decompress(body)?;
            // Compressed data are stored field by field.
            header.points(&body, |field, index| field.offset * header.points + index * field.size)
        }
        other => {
            return Err(format!("PCD data are '{other}'; expected ascii, binary or binary_compressed"));
        }
    };
    let float = |field: &Field| field.kind == 'F' && field.size == 4;
    // Text may have more digits than the type that the header names.
    let narrow = header.data != "ascii" && header.axes.iter().all(float);
    let points = if narrow {
        Cloud::F32(points.iter().map(|p| p.map(|x| x as f32)).collect())
    } else {
        Cloud::F64(points)
    };
    Ok(CloudFile { points, columns: header.columns_of_grid })
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let (mut names, mut sizes, mut kinds, mut counts) = (vec![], vec![], vec![], vec![]);
        let (mut width, mut height, mut points) = (None, None, None);
        let mut end = 0;
        let data = loop {
            let length = bytes[end..].iter().position(|&byte| byte == b'\n');
            let length = length.ok_or("has no PCD line DATA; the file is cut off or no PCD file")?;
            let line = std::str::from_utf8(&bytes[end..end + length])
                .map_err(|_| "is no PCD file: its header is not text")?;
            end += length + 1;
            let mut words = line.split('#').next().unwrap_or_default().split_ascii_whitespace();
            let Some(key) = words.next() else { continue };
            let values: Vec<&str> = words.collect();
            let number = |word: &str| {
                let bad = |_| format!("PCD line {key} has '{word}'; expected a whole number");
                word.parse::<usize>().map_err(bad)
            };
            let single = || number(values.first().copied().unwrap_or_default());
            let all = || values.iter().map(|word| number(word)).collect::<Result<Vec<_>, _>>();
            match key {
                "FIELDS" | "COLUMNS" => names = values.iter().map(ToString::to_string).collect(),
                "SIZE" => sizes = all()?,
                "TYPE" => kinds = values.iter().filter_map(|word| word.chars().next()).collect(),
                "COUNT" => counts = all()?,
                "WIDTH" => width = Some(single()?),
                "HEIGHT" => height = Some(single()?),
                "POINTS" => points = Some(single()?),
                "DATA" => break values.first().copied().unwrap_or_default().to_string(),
                // VERSION and VIEWPOINT say nothing about the numbers.
                _ => {}
            }
        };
        if counts.is_empty() {
            counts = vec![1; names.len()];
        }
        if names.is_empty() || [sizes.len(), kinds.len(), counts.len()] != [names.len(); 3] {
            return Err(format!(
                "PCD header has {} FIELDS, {} SIZE, {} TYPE and {} COUNT; all must be equally many",
                names.len(),
                sizes.len(),
                kinds.len(),
                counts.len()
            ));
        }
        let area = width.zip(height).and_then(|(width, height)| width.checked_mul(height));
        let points = points.or(area).ok_or("PCD header has neither POINTS nor WIDTH and HEIGHT")?;
        let is_grid = height.is_some_and(|height| height > 1) && area == Some(points);
        let columns_of_grid = width.filter(|&width| is_grid && width > 1);
        let (mut offset, mut column) = (0_usize, 0_usize);
        let mut axes = [None; 3];
        for (index, name) in names.iter().enumerate() {
            let (kind, size) = (kinds[index], sizes[index]);
            if let Some(axis) = ["x", "y", "z"].iter().position(|axis| axis == name) {
                if !matches!((kind, size), ('F', 4 | 8) | ('I' | 'U', 1 | 2 | 4 | 8)) {
                    return Err(format!(
                        "PCD field {name} has TYPE {kind} and SIZE {size}; expected F with 4 or 8, or I or U \
                         with 1, 2, 4 or 8"
                    ));
                }
                if counts[index] != 1 {
                    return Err(format!("PCD field {name} has COUNT {}; expected 1", counts[index]));
                }
                axes[axis] = Some(Field { kind, size, offset, column });
            }
            let step = size.checked_mul(counts[index]).and_then(|bytes| offset.checked_add(bytes));
            offset = step.ok_or_else(|| format!("PCD field {name} is too large for any memory"))?;
            column = column.saturating_add(counts[index]);
        }
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(format!("PCD FIELDS are {}; x, y and z must be among them", names.join(" ")));
        };
        Ok(Self { axes: [x, y, z], points, columns_of_grid, point_size: offset, columns: column, data, end })
    }

    /// The bytes of all points, if there are as many.
    fn take<'a>(&self, body: &'a [u8], what: &str) -> Result<&'a [u8], String> {
        let length = self.points.checked_mul(self.point_size);
        length.and_then(|length| body.get(..length)).ok_or_else(|| {
            format!(
                "PCD {what}: {} points of {} bytes do not fit the {} bytes there are; the file is cut off or \
                 its header wrong",
                self.points,
                self.point_size,
                body.len()
            )
        })
    }

    /// The points in `body`, where `position` tells the first byte of a number. `body` holds all of them.
    fn points(&self, body: &[u8], position: impl Fn(&Field, usize) -> usize) -> Vec<[f64; 3]> {
        let point = |index| self.axes.map(|field| field.number(&body[position(&field, index)..]));
        (0..self.points).map(point).collect()
    }

    fn ascii(&self, body: &[u8]) -> Result<Vec<[f64; 3]>, String> {
        let text = std::str::from_utf8(body).map_err(|_| "PCD ascii data are not text".to_string())?;
        let mut points = Vec::new();
        for line in text.lines().filter(|line| !line.trim().is_empty()).take(self.points) {
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let index = points.len();
            if words.len() != self.columns {
                let (given, columns) = (words.len(), self.columns);
                return Err(format!("PCD point {index} has {given} numbers; the header says {columns}"));
            }
            let mut point = [0.0; 3];
            for (coordinate, field) in point.iter_mut().zip(&self.axes) {
                let word = words[field.column];
                let parsed = word.parse();
                *coordinate =
                    parsed.map_err(|_| format!("PCD point {index} has '{word}'; expected a number"))?;
            }
            points.push(point);
        }
        if points.len() != self.points {
            let (given, promised) = (points.len(), self.points);
            return Err(format!("PCD file has {given} points; the header promises {promised}"));
        }
        Ok(points)
    }

    fn decompress(&self, body: &[u8]) -> Result<Vec<u8>, String> {
        let cut_off = || "PCD compressed data are cut off".to_string();
        let word = |at: usize| {
            let bytes = body.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).ok_or_else(cut_off)?;
            Ok::<usize, String>(u32::from_le_bytes(bytes) as usize)
        };
        let (compressed, size) = (word(0)?, word(4)?);
        let input = body.get(8..).and_then(|rest| rest.get(..compressed)).ok_or_else(cut_off)?;
        // Memory is taken only for what the input can really hold.
        if size > LZF_MAX_RATIO * input.len() {
            return Err(format!("PCD data of {compressed} bytes cannot hold the {size} that they promise"));
        }
        let body = decompress_lzf(input, size).ok_or("PCD compressed data are damaged")?;
        self.take(&body, "compressed data")?;
        Ok(body)
    }
}

impl Field {
    /// The number at the start of `bytes`, which is as long as the field.
    fn number(self, bytes: &[u8]) -> f64 {
        let mut raw = [0; 8];
        raw[..self.size].copy_from_slice(&bytes[..self.size]);
        let unsigned = u64::from_le_bytes(raw);
        // The sign bit of a shorter integer is moved to the top and back.
        let unused = 64 - 8 * self.size as u32;
        match (self.kind, self.size) {
            ('F', 4) => f64::from(f32::from_bits(unsigned as u32)),
            ('F', _) => f64::from_bits(unsigned),
            ('I', _) => ((unsigned << unused) as i64 >> unused) as f64,
            _ => unsigned as f64,
        }
    }
}

/// LZF of Marc Lehmann: runs of literal bytes and references to earlier output. `None` when damaged.
fn decompress_lzf(input: &[u8], size: usize) -> Option<Vec<u8>> {
    let mut output = Vec::with_capacity(size);
    let mut rest = input;
    while let Some((&control, mut tail)) = rest.split_first() {
        if control < 32 {
            let (literal, after) = tail.split_at_checked(usize::from(control) + 1)?;
            output.extend_from_slice(literal);
            rest = after;
        } else {
            let mut length = usize::from(control >> 5) + 2;
            if length == 9 {
                let (&more, after) = tail.split_first()?;
                length += usize::from(more);
                tail = after;
            }
            let (&low, after) = tail.split_first()?;
            let back = (usize::from(control & 31) << 8) + usize::from(low) + 1;
            let start = output.len().checked_sub(back)?;
            // Byte by byte, because the copy may run into its own output.
            for k in start..start + length {
                output.push(output[k]);
            }
            rest = after;
        }
        if output.len() > size {
            return None;
        }
    }
    (output.len() == size).then_some(output)
}

/// Writes points as a binary PCD file.
pub fn write(points: &[[f32; 3]], to: &mut impl Write) -> std::io::Result<()> {
    let count = points.len();
    write!(
        to,
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n\
         COUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n"
    )?;
    to.write_all(&little_endian(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f32; 3]; 2] = [[1.5, -2.25, 0.1], [4.0, 5.0, 6.0]];

    #[test]
    fn what_is_written_is_read_back() {
        let mut file = Vec::new();
        write(&POINTS, &mut file).unwrap();
        assert_eq!(parse(&file).unwrap(), Cloud::F32(POINTS.to_vec()).into());
        file.pop();
        assert!(parse(&file).unwrap_err().contains("cut off"));
    }

    #[test]
    fn text_with_other_fields_is_read() {
        let file = "VERSION .7\nFIELDS rgb z y histogram x\nSIZE 4 8 4 4 2\nTYPE F F F F I\nCOUNT 1 1 1 2 1\n\
                    WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n0 3 2 9 9 1\n0 nan 5 9 9 4\n";
        let Cloud::F64(points) = parse(file.as_bytes()).unwrap().points else { panic!("text is f64") };
        assert_eq!(points[0], [1.0, 2.0, 3.0]);
        assert!(points[1][2].is_nan());
    }

    #[test]
    fn compressed_data_are_read_field_by_field() {
        let columns: Vec<u8> =
            (0..3).flat_map(|k| POINTS.iter().flat_map(move |p| p[k].to_le_bytes())).collect();
        let mut data = vec![columns.len() as u8 - 1];
        data.extend(&columns);
        let mut file = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA binary_compressed\n".to_vec();
        file.extend((data.len() as u32).to_le_bytes());
        file.extend((columns.len() as u32).to_le_bytes());
        file.extend(data);
        assert_eq!(parse(&file).unwrap(), Cloud::F32(POINTS.to_vec()).into());
        for length in 0..file.len() {
            assert!(parse(&file[..length]).is_err());
        }
    }

    #[test]
    fn organised_clouds_keep_their_rows() {
        let size = |width: usize, height: usize| {
            let header = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
            let file = format!(
                "{header}WIDTH {width}\nHEIGHT {height}\nPOINTS 6\nDATA ascii\n{}",
                "1 2 3\n".repeat(6)
            );
            let file = parse(file.as_bytes()).unwrap();
            let view = file.view().unwrap();
            (view.width(), view.height())
        };
        assert_eq!(size(3, 2), (3, 2));
        // A list, and a header that contradicts itself.
        for (width, height) in [(6, 1), (1, 6), (4, 2), (0, 0)] {
            assert_eq!(size(width, height), (6, 1));
        }
    }

    #[test]
    fn lzf_references_may_overlap_their_output() {
        // "ab", then 7 bytes from 2 back.
        assert_eq!(decompress_lzf(&[1, b'a', b'b', 5 << 5, 1], 9).unwrap(), b"ababababa");
        // A long reference: 7 + 3 + 2 bytes from 1 back.
        assert_eq!(decompress_lzf(&[0, b'x', 7 << 5, 3, 0], 13).unwrap(), [b'x'; 13]);
        for (input, size) in
            [(&[0][..], 1), (&[32, 0], 3), (&[0, 1], 2), (&[0, 1, 2 << 5], 5), (&[0, 1, 0, 2], 1)]
        {
            assert!(decompress_lzf(input, size).is_none(), "{input:?}");
        }
    }

    #[test]
    fn signed_and_unsigned_integers_are_told_apart() {
        let field = |kind, size| Field { kind, size, offset: 0, column: 0 };
        assert_eq!(field('I', 2).number(&[0xfe, 0xff]), -2.0);
        assert_eq!(field('U', 2).number(&[0xfe, 0xff]), 65534.0);
        assert_eq!(field('I', 8).number(&[0xff; 8]), -1.0);
    }

    #[test]
    fn bad_headers_are_refused() {
        for (header, reason) in [
            ("", "DATA"),
            ("FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 0\nDATA ascii\n", "x, y and z"),
            ("FIELDS x y z\nSIZE 4 4\nTYPE F F F\nPOINTS 0\nDATA ascii\n", "equally many"),
            ("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 0\nDATA ascii\n", "SIZE 3"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 0\nPOINTS 1\nDATA binary\n12345678", "COUNT 0"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 0\nPOINTS 1\nDATA ascii\n1 2\n", "COUNT 0"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 2 1\nPOINTS 0\nDATA ascii\n", "COUNT 2"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS -1\nDATA ascii\n", "'-1'"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nDATA ascii\n", "neither"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA zip\n", "'zip'"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 99999999999999\nDATA binary\n", "cut off"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n1 2 3\n", "promises 2"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2\n", "2 numbers"),
            ("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 k\n", "'k'"),
        ] {
            let error = parse(header.as_bytes()).unwrap_err();
            assert!(error.contains(reason), "{error}");
        }
    }
}
