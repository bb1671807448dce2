//! Text clouds: a point a line, x y z first.

use super::Cloud;

/// Numbers are separated by whitespace, commas or semicolons; # starts a comment; further columns are ignored.
pub fn parse(bytes: &[u8]) -> Result<Cloud, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        format!("is no text: byte {at} is not UTF-8; expected lines of x y z")
    })?;
    let mut points = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let content = line.split('#').next().unwrap_or_default();
        let mut words = content.split([' ', '\t', ',', ';', '\r']).filter(|word| !word.is_empty());
        let mut point = [0.0; 3];
        let mut count = 0;
        for (coordinate, word) in point.iter_mut().zip(&mut words) {
            *coordinate = word
                .parse()
                .map_err(|_| format!("line {number}: '{word}' is not a number; expected x y z"))?;
            count += 1;
        }
        match count {
            0 => {}
            3 => points.push(point),
            _ => return Err(format!("line {number} has {count} numbers; expected x y z")),
        }
    }
    Ok(Cloud::F64(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_comments_and_extra_columns_are_understood() {
        let text = b"# x y z\n1 2 3\n\n 4.5,5e-1,-6 , 255 0 0\r\n7;8;nan # last\n";
        let Cloud::F64(points) = parse(text).unwrap() else { panic!("text is f64") };
        assert_eq!(points[..2], [[1.0, 2.0, 3.0], [4.5, 0.5, -6.0]]);
        assert!(points.len() == 3 && points[2][2].is_nan());
    }

    #[test]
    fn bad_lines_are_named() {
        assert_eq!(parse(b"1 2 3\n4 5\n").unwrap_err(), "line 2 has 2 numbers; expected x y z");
        assert_eq!(parse(b"x y z\n").unwrap_err(), "line 1: 'x' is not a number; expected x y z");
        assert!(parse(&[0xff, 0xfe]).unwrap_err().contains("byte 0"));
    }
}
