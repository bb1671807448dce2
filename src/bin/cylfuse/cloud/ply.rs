//! PLY: read by `ply-rs-bw` (ASCII and binary of either byte order, with any other elements around the
//! vertices), written as binary floats, which need four lines.

use super::{Cloud, little_endian};
use crate::canvas::color_of;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use std::borrow::Cow;
use std::io::{Cursor, Write};

/// What `ply-rs-bw` reads as infinite: more than a double holds.
const INFINITE: &str = "1e999";

/// Reads the vertices of a PLY file.
pub fn parse(bytes: &[u8]) -> Result<Cloud, String> {
    let bytes = &*with_infinite_numbers(bytes);
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|error| bad("header", &error))?;
    let mut vertex = check(&header, bytes.len())?.clone();
    let mut wide = false;
    for name in ["x", "y", "z"] {
        let property = vertex.properties.get_mut(name);
        match property.map(|property| &mut property.data_type) {
            // Text may have more digits than the type that the header names.
            Some(PropertyType::Scalar(scalar)) if header.encoding == Encoding::Ascii => {
                *scalar = ScalarType::Double;
                wide = true;
            }
            Some(PropertyType::Scalar(scalar)) => wide |= *scalar != ScalarType::Float,
            Some(PropertyType::List(..)) => {
                return Err(format!("the PLY property {name} is a list; expected a number"));
            }
            None => return Err(format!("the PLY vertices have no property {name}; expected x, y and z")),
        }
    }
    // Elements follow each other without an index: those before the vertices have to be read to be skipped.
    for element in header.elements.values().take_while(|element| element.name != "vertex") {
        let skipped = Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header);
        skipped.map_err(|error| bad(&format!("element {}", element.name), &error))?;
    }
    let vertices = Parser::<Vertex>::new()
        .read_payload_for_element(&mut reader, &vertex, &header)
        .map_err(|error| bad("vertices", &error))?;
    Ok(if wide {
        Cloud::F64(vertices.iter().map(|v| v.0).collect())
    } else {
        Cloud::F32(vertices.iter().map(|v| v.0.map(|x| x as f32)).collect())
    })
}

/// What is wrong with a part of a file, without the characters that the grammar expects, which tell nobody anything.
fn bad(part: &str, error: &ParseError) -> String {
    let text = error.to_string();
    let reason = text.split("\n\tError: Couldn't parse element line").next().unwrap_or(&text);
    format!("bad PLY {part}: {reason}")
}

/// An ASCII file with an infinite number for every word that is no finite one: the grammar of `ply-rs-bw` knows neither `nan`, which PCL
/// writes for points that were not measured, nor `inf`.
fn with_infinite_numbers(bytes: &[u8]) -> Cow<'_, [u8]> {
    const HEADER_ENDS: &str = "end_header";
    // Binary files are no text, but for some of a few bytes.
    let Ok(text) = std::str::from_utf8(bytes) else { return Cow::Borrowed(bytes) };
    let Some((header, body)) = text.split_once(HEADER_ENDS) else { return Cow::Borrowed(bytes) };
    if !header.contains("format ascii") {
        return Cow::Borrowed(bytes);
    }
    let is_infinite = |word: &str| word.parse::<f64>().is_ok_and(|number| !number.is_finite());
    let finite = |piece: &str| match piece.trim_ascii() {
        word if is_infinite(word) => piece.replace(word, INFINITE),
        _ => piece.to_owned(),
    };
    let body: String = body.split_inclusive(|c: char| c.is_ascii_whitespace()).map(finite).collect();
    Cow::Owned([header, HEADER_ENDS, &body].concat().into_bytes())
}

/// The definition of the vertices; refuses headers that promise more than the file can hold.
fn check(header: &Header, file_size: usize) -> Result<&ElementDef, String> {
    for element in header.elements.values() {
        if element.properties.is_empty() || element.count > file_size {
            return Err(format!(
                "the PLY header promises {} elements {} with {} properties in {file_size} bytes; the file is \
                 cut off or its header wrong",
                element.count,
                element.name,
                element.properties.len()
            ));
        }
    }
    header.elements.get("vertex").ok_or_else(|| "the PLY file has no element vertex".into())
}

/// The position of a vertex. Floats pass through f64 unchanged.
#[derive(Clone, Copy)]
struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let coordinate = match name {
            "x" => &mut self.0[0],
            "y" => &mut self.0[1],
            "z" => &mut self.0[2],
            _ => return PropertyAccessResult::Ignored,
        };
        *coordinate = match property {
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that does not matter.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// Writes points as a binary PLY file.
pub fn write(points: &[[f32; 3]], to: &mut impl Write) -> std::io::Result<()> {
    write!(
        to,
        "ply\nformat binary_little_endian 1.0\ncomment completed by cylfuse, metres\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\nend_header\n",
        points.len()
    )?;
    to.write_all(&little_endian(points))
}

/// Writes points with the number of the cylinder of each, 0 for none, as a property and as a colour. Coordinates stay as wide
/// as they are.
pub fn write_numbered(points: &Cloud, numbers: &[u16], to: &mut impl Write) -> std::io::Result<()> {
    let (count, scalar) = match points {
        Cloud::F32(points) => (points.len(), "float"),
        Cloud::F64(points) => (points.len(), "double"),
    };
    write!(
        to,
        "ply\nformat binary_little_endian 1.0\ncomment written by cylfuse; cylinder 0: none, k: the k-th\n\
         element vertex {count}\nproperty {scalar} x\nproperty {scalar} y\nproperty {scalar} z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty ushort cylinder\nend_header\n"
    )?;
    for (index, &number) in numbers.iter().take(count).enumerate() {
        match points {
            Cloud::F32(points) => to.write_all(&little_endian(&points[index..=index]))?,
            Cloud::F64(points) => {
                points[index].iter().try_for_each(|coordinate| to.write_all(&coordinate.to_le_bytes()))?;
            }
        }
        let [red, green, blue] = usize::from(number).checked_sub(1).map_or(REST, color_of);
        to.write_all(&[red, green, blue])?;
        to.write_all(&number.to_le_bytes())?;
    }
    Ok(())
}

/// The colour of what is no cylinder.
const REST: [u8; 3] = [128; 3];

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f32; 3]; 2] = [[1.5, -2.25, 0.1], [4.0, 5.0, 6.0]];

    #[test]
    fn what_is_written_is_read_back() {
        let mut file = Vec::new();
        write(&POINTS, &mut file).unwrap();
        assert_eq!(parse(&file).unwrap(), Cloud::F32(POINTS.to_vec()));
        file.truncate(file.len() - 1);
        assert!(parse(&file).unwrap_err().contains("vertex"));
    }

    #[test]
    fn numbered_points_are_read_back_as_wide_as_they_were() {
        let wide = vec![[4.0e6, 0.1, -7.0], [1.0 / 3.0, 2.0, 3.0]];
        for cloud in [Cloud::F32(POINTS.to_vec()), Cloud::F64(wide)] {
            let mut file = Vec::new();
            write_numbered(&cloud, &[0, 258], &mut file).unwrap();
            assert_eq!(parse(&file).unwrap(), cloud);
            assert!(file.ends_with(&[2, 1]), "the number of the last point");
        }
    }

    #[test]
    fn doubles_lists_and_other_elements_are_understood() {
        let text = "ply\nformat ascii 1.0\nelement camera 1\nproperty list uchar float k\nelement vertex 1\n\
                    property uchar red\nproperty double y\nproperty float x\nproperty int z\nend_header\n\
                    2 0.5 0.5\n255 0.1 2.5 -7\n";
        assert_eq!(parse(text.as_bytes()).unwrap(), Cloud::F64(vec![[2.5, 0.1, -7.0]]));
    }

    /// It said that it could not parse the line.
    #[test]
    fn points_that_were_not_measured_are_not_finite() {
        let header = "ply\r\nformat ascii 1.0\r\ncomment nan\r\nelement vertex 4\r\nproperty float x\r\n\
                      property float y\r\nproperty float z\r\nend_header\r\n";
        for rows in [["nan nan nan", "-nan 1 NaN"], ["inf -inf 2", " -Infinity\t3 nan "]] {
            let text = format!("{header}1 -2 3\r\n{}\r\n{}\r\n4 5 6", rows[0], rows[1]);
            let Cloud::F64(points) = parse(text.as_bytes()).unwrap() else {
                panic!("text is read as doubles")
            };
            assert_eq!((points.len(), points[0], points[3]), (4, [1.0, -2.0, 3.0], [4.0, 5.0, 6.0]));
            assert!(points[1..3].iter().all(|point| point.iter().any(|x| !x.is_finite())));
        }
        let text = format!("{header}1 -2 3\nnana nan nan\n1 2 3\n4 5 6\n");
        let error = parse(text.as_bytes()).unwrap_err();
        assert!(error.contains("'nana") && !error.contains("expected one of"), "{error}");
    }

    #[test]
    fn headers_that_promise_too_much_are_refused() {
        for (header, reason) in [
            ("element vertex 99999999999\nproperty float x\n", "99999999999"),
            ("element empty 5\nelement vertex 0\nproperty float x\n", "0 properties"),
            ("element vertex 1\nproperty float x\nproperty float y\n", "no property z"),
            ("element face 0\nproperty list uchar int i\n", "no element vertex"),
            ("element vertex 1\nproperty list uchar int x\n", "is a list"),
            ("element\n", "header"),
        ] {
            let file = format!("ply\nformat ascii 1.0\n{header}end_header\n");
            let error = parse(file.as_bytes()).unwrap_err();
            assert!(error.contains(reason), "{error}");
        }
        assert!(parse(b"").is_err() && parse(&[0xff; 100]).is_err());
    }
}
