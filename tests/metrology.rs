//! The orthogonal least-squares fit against answers of 45 digits from an independent solver in multi-precision arithmetic:
//! `tests/metrology.py` makes the sets of `tests/data/metrology.json` from seeds, and solves them.
//!
//! Sets of NIST (`NAME.ds` with the points and `NAME.fit` with the cylinder) are read from the folder that `CYLFUSE_NIST`
//! names.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use cylfuse::fitter::{Fitter, IterationLimits, Method, NearWall, Options, StartKind};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::PointsView;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Largest deviation of the surface where the data are, by their size, for a condition up to [`ORDINARY`].
const DEVIATION: f64 = 1e-9;

/// Condition numbers of the Jacobian up to this one are those of full and half circles; beyond it, on shorter arcs, the
/// permitted deviation grows with the condition.
const ORDINARY: f64 = 10.0;

/// The same, where the fit ends by the default tolerance of the cost.
const DEFAULT_DEVIATION: f64 = 1e-8;

/// Numbers of digits that an answer must have.
const DIGITS: usize = 40;

/// SplitMix64, as in the script.
struct Stream(u64);

impl Stream {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|k, _| value[k].as_f64().unwrap())
}

/// Numbers that are written as text, for their digits.
fn exact(value: &Value) -> f64 {
    let text = value.as_str().unwrap();
    text.parse().unwrap()
}

/// The rotation of a set: rows of integers, by their common divisor.
fn rotation(case: &Value) -> [[f64; 3]; 3] {
    let [w, x, y, z] = [0, 1, 2, 3].map(|k| case["quaternion"][k].as_i64().unwrap());
    let norm = (w * w + x * x + y * y + z * z) as f64;
    [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    .map(|row| row.map(|entry| entry as f64 / norm))
}

/// The coordinates of a set: the operations of the script in their order, so the same bits.
fn points(case: &Value) -> Vec<[f64; 3]> {
    let mut stream = Stream(case["seed"].as_u64().unwrap());
    let rows = rotation(case);
    let of = |name: &str| number(&case[name]);
    let (radius, half, arc) = (of("radius"), of("half_length"), of("arc"));
    let (oval, lobes, barrel, noise) = (of("oval"), of("lobes"), of("barrel"), of("noise"));
    let (full, offset) = (case["full"].as_bool().unwrap(), vector(&case["offset"]));
    let point = |_| {
        let t = arc * (2.0 * stream.unit() - 1.0);
        let along = 2.0 * stream.unit() - 1.0;
        let error = ((stream.unit() + stream.unit()) + (stream.unit() + stream.unit())) - 2.0;
        let behind = stream.unit() < 0.5;
        let c = (1.0 - t * t) / (1.0 + t * t);
        let s = (2.0 * t) / (1.0 + t * t);
        let c = if full && behind { -c } else { c };
        let form = (oval * (2.0 * c * c - 1.0) + lobes * ((4.0 * c * c - 3.0) * c))
            + (barrel * (along * along) + noise * error);
        let distance = radius + form;
        let (x, y, z) = (distance * c, distance * s, half * along);
        [0, 1, 2].map(|k| ((rows[k][0] * x + rows[k][1] * y) + rows[k][2] * z) + offset[k])
    };
    (0..case["points"].as_u64().unwrap()).map(point).collect()
}

/// The fit of points alone by least squares, from a cylinder or from a start of its own, until the cost falls by no more than
/// a tolerance.
fn fit(points: &[[f64; 3]], start: Option<Cylinder>, cost_tolerance: f64) -> Cylinder {
    let mut fitter = Fitter::new();
    fitter.push_points(&PointsView::from_f64(points), None).unwrap();
    let kind = if start.is_some() { StartKind::Model } else { StartKind::Auto };
    fitter.set_start(start);
    let limits = IterationLimits { cost_tolerance, ..IterationLimits::default() };
    let near_wall = NearWall::Off;
    let options = Options { method: Method::Points, start: kind, near_wall, limits, ..Options::default() };
    fitter.set_options(options).unwrap();
    fitter.fit().unwrap().cylinder
}

/// How far two cylinders are apart where the data are, by the size of the data: axis at their middle, tilt over half of
/// their length, radius.
fn deviation(fitted: &Cylinder, answer: &Cylinder, middle: &Vector3<f64>, half: f64, size: f64) -> f64 {
    let [a, b] = [fitted, answer].map(|cylinder| cylinder.axis.nearest_to(middle));
    let tilt = fitted.axis.direction.cross(&answer.axis.direction).norm() * half;
    [(a - b).norm(), tilt, (fitted.radius - answer.radius).abs()].into_iter().fold(0.0, f64::max) / size
}

fn sets() -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/metrology.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn answer(case: &Value) -> Cylinder {
    let [point, direction] =
        ["point", "direction"].map(|name| Vector3::from_fn(|k, _| exact(&case[name][k])));
    Cylinder::new(point, direction, exact(&case["radius_fitted"])).unwrap()
}

/// The cylinder that a set was made from.
fn nominal(case: &Value) -> Cylinder {
    let axis = Vector3::from(rotation(case).map(|row| row[2]));
    Cylinder::new(vector(&case["offset"]), axis, number(&case["radius"])).unwrap()
}

#[test]
fn the_fit_agrees_with_answers_of_40_digits() {
    let sets = sets();
    assert!(sets.len() >= 300, "{}", sets.len());
    let mut failures = Vec::new();
    // By decade of the condition: fits, and the largest deviations without and with the default tolerance.
    let mut worst = [(0, [0.0_f64; 2]); 7];
    let mut own_starts = 0;
    for case in &sets {
        let digits = case["radius_fitted"].as_str().unwrap().chars().filter(char::is_ascii_digit).count();
        assert!(digits >= DIGITS, "{case}");
        let (points, answer) = (points(case), answer(case));
        let (half, condition) = (number(&case["half_length"]), number(&case["condition"]));
        let size = half.max(number(&case["radius"]));
        // Many points on a wide arc have one minimum; the fit must find it by itself.
        let alone = points.len() >= 50 && number(&case["arc"]) > 0.25;
        own_starts += usize::from(alone);
        let starts = [Some(Some(nominal(case))), alone.then_some(None)];
        for start in starts.into_iter().flatten() {
            let of = |tolerance: f64| {
                let fitted = fit(&points, start, tolerance);
                deviation(&fitted, &answer, &vector(&case["offset"]), half, size)
            };
            let decade = (condition.log10().floor() as usize).min(6);
            let found = [of(0.0), of(IterationLimits::default().cost_tolerance)];
            worst[decade].0 += 1;
            for (k, limit) in [DEVIATION, DEFAULT_DEVIATION].into_iter().enumerate() {
                let permitted = limit * (condition / ORDINARY).max(1.0);
                worst[decade].1[k] = worst[decade].1[k].max(found[k]);
                if !(found[k] <= permitted) {
                    let by = if start.is_some() { "given" } else { "own" };
                    failures.push(format!(
                        "{}, {} points, condition {condition}, {by} start: {:.1e}, permitted {permitted:.1e}",
                        case["name"],
                        points.len(),
                        found[k]
                    ));
                }
            }
        }
    }
    println!("{} sets, {own_starts} of them also from a start of the fit's own", sets.len());
    for (decade, (count, [found, by_default])) in worst.iter().enumerate().filter(|(_, row)| row.0 > 0) {
        println!(
            "condition from 1e{decade}: {count} fits, largest deviation {found:.1e} of the size, {by_default:.1e} with the \
             default tolerance"
        );
    }
    assert!(failures.is_empty(), "{} fits:\n{}", failures.len(), failures.join("\n"));
}

/// A pair of NIST's files: points, a line each; and the answer with a point of the axis, its direction and its size.
struct Pair {
    points: Vec<[f64; 3]>,
    answer: Cylinder,
}

/// All numbers of a file. Lines that hold words are comments.
fn numbers(path: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let separators = |c: char| c.is_whitespace() || c == ',';
    let line = |line: &str| {
        let words = line.split(separators).filter(|word| !word.is_empty());
        words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>().unwrap_or_default()
    };
    text.lines().flat_map(line).collect()
}

/// Reads `NAME.ds` and the `NAME.fit` beside it. The last number of the answer is a radius or a diameter, which the files do
/// not say; of the two the one that the points lie nearer to counts.
fn read_pair(path: &Path) -> Pair {
    let coordinates = numbers(path);
    assert_eq!(coordinates.len() % 3, 0, "{}: coordinates come in threes", path.display());
    let points: Vec<[f64; 3]> = coordinates.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let [px, py, pz, dx, dy, dz, last] = numbers(&path.with_extension("fit"))[..] else {
        panic!("{}: a cylinder has seven numbers", path.with_extension("fit").display());
    };
    let of = |radius: f64| {
        let cylinder = Cylinder::new(Vector3::new(px, py, pz), Vector3::new(dx, dy, dz), radius).unwrap();
        let squares = points.iter().map(|p| cylinder.distance(&Vector3::from(*p)).powi(2)).sum::<f64>();
        (squares, cylinder)
    };
    let (radius, half) = (of(last), of(0.5 * last));
    let answer = if radius.0 < half.0 { radius.1 } else { half.1 };
    Pair { points, answer }
}

/// How far the fit to a pair is from its answer, by the size of the data.
fn deviation_of(pair: &Pair) -> f64 {
    let middle =
        pair.points.iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / pair.points.len() as f64;
    let along = |p: &[f64; 3]| (Vector3::from(*p) - middle).dot(&pair.answer.axis.direction);
    let reach = pair.points.iter().map(along).fold(0.0, |most: f64, t| most.max(t.abs()));
    let fitted = fit(&pair.points, Some(pair.answer), 0.0);
    deviation(&fitted, &pair.answer, &middle, reach, reach.max(pair.answer.radius))
}

#[test]
fn files_of_nist_are_read() {
    let sets = sets();
    let case = sets.iter().find(|case| case["points"] == 100).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cylinder.ds");
    let lines: String = points(case).iter().map(|[x, y, z]| format!("{x:e} {y:e}\t{z:e}\r\n")).collect();
    std::fs::write(&path, format!("cylinder, 100 points\n{lines}")).unwrap();
    let answer = answer(case);
    for factor in [1.0, 2.0] {
        let (p, d) = (answer.axis.point, answer.axis.direction);
        let text = format!("{} {} {}\n{} {} {}\n{}\n", p.x, p.y, p.z, d.x, d.y, d.z, factor * answer.radius);
        std::fs::write(path.with_extension("fit"), text).unwrap();
        let pair = read_pair(&path);
        assert_eq!((pair.points.len(), pair.answer.radius), (100, answer.radius));
        assert!(deviation_of(&pair) < DEVIATION, "{:e}", deviation_of(&pair));
    }
}

#[test]
fn sets_of_nist() {
    let Some(folder) = std::env::var_os("CYLFUSE_NIST").map(PathBuf::from) else {
        println!("skipped: CYLFUSE_NIST names no folder with NAME.ds and NAME.fit");
        return;
    };
    let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let mut pairs: Vec<PathBuf> = files
        .filter(|path| path.extension().is_some_and(|extension| extension == "ds"))
        .filter(|path| path.with_extension("fit").is_file())
        .collect();
    pairs.sort();
    assert!(!pairs.is_empty(), "{} has no NAME.ds with a NAME.fit", folder.display());
    for path in pairs {
        let found = deviation_of(&read_pair(&path));
        println!("{}: {found:.1e} of the size", path.display());
        assert!(found < DEVIATION, "{}: {found:e}", path.display());
    }
}
