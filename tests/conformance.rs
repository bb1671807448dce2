//! The golden cases of bindings/conformance by the Rust API, against the committed values.
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "../bindings/conformance/rust/run.rs"]
mod run;

use run::Runner;
use serde_json::Value;

/// What counts steps or is what rounding leaves over differs with the mathematical library of the machine.
const NOT_COMPARED: [&str; 6] =
    ["iterations", "rejected_steps", "lambda", "gradient_norm", "step_norm", "termination"];

fn expected(value: &Value) -> f64 {
    match value.as_str() {
        Some(infinity) => infinity.parse().unwrap(),
        None => value.as_f64().unwrap_or(f64::NAN),
    }
}

/// Whether lists agree to 1e-9 of their largest number.
fn near(values: &[f64], expected: &[f64]) -> bool {
    let scale = expected.iter().filter(|x| x.is_finite()).fold(0.0, |scale: f64, x| scale.max(x.abs()));
    let near = |(x, y): (&f64, &f64)| x == y || (x.is_nan() && y.is_nan()) || (x - y).abs() <= 1e-9 * scale;
    values.len() == expected.len() && values.iter().zip(expected).all(near)
}

#[test]
fn golden_cases_give_the_committed_values() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("bindings/conformance/cases.json");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let mut runner = Runner::new(&file);
        for (index, step) in case["steps"].as_array().unwrap().iter().enumerate() {
            let at = format!("{}, step {index} ({})", case["name"], step["call"]);
            match runner.step(step) {
                Ok(fields) => {
                    assert!(step["error"].is_null(), "{at} succeeds");
                    assert_eq!(
                        fields.len(),
                        step["expect"].as_object().map_or(0, serde_json::Map::len),
                        "{at}"
                    );
                    for (name, values) in fields {
                        let committed: Vec<f64> =
                            step["expect"][&name].as_array().unwrap().iter().map(expected).collect();
                        let compared = !NOT_COMPARED.contains(&name.as_str());
                        assert!(!compared || near(&values, &committed), "{at}: {name} is {values:?}");
                    }
                }
                Err((status, message)) => assert_eq!(step["error"]["status"], status, "{at}: {message}"),
            }
        }
    }
}
