//! The golden cases by the Rust API.
//!
//! `cargo run --release --example conformance -- --write` writes bindings/conformance/cases.json anew;
//! without `--write` it runs the cases of that file and prints the results as bits.

#![allow(clippy::unwrap_used)] // A generator that cannot go on should stop.

mod cases;
mod detectors;
mod failures;
mod pair;
mod run;
mod scene;
mod views;

use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// The file with one step a line, so that a change of a step is a change of a line.
fn text(file: &Value) -> String {
    let mut text = String::from("{\n");
    for key in ["arrays", "cameras"] {
        let entries: Vec<String> = file[key]
            .as_object()
            .unwrap()
            .iter()
            .map(|(name, value)| format!("  \"{name}\": {value}"))
            .collect();
        let _ = writeln!(text, " \"{key}\": {{\n{}\n }},", entries.join(",\n"));
    }
    let cases: Vec<String> = file["cases"]
        .as_array()
        .unwrap()
        .iter()
        .map(|case| {
            let steps: Vec<String> =
                case["steps"].as_array().unwrap().iter().map(|step| format!("   {step}")).collect();
            let (name, about) = (&case["name"], &case["about"]);
            format!("  {{\"name\": {name}, \"about\": {about}, \"steps\": [\n{}\n  ]}}", steps.join(",\n"))
        })
        .collect();
    let _ = write!(text, " \"cases\": [\n{}\n ]\n}}\n", cases.join(",\n"));
    text
}

/// JSON has no NaN and no infinity: null and the text "inf" or "-inf".
fn decimal(x: &f64) -> Value {
    if x.is_infinite() { json!(if *x > 0.0 { "inf" } else { "-inf" }) } else { json!(x) }
}

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("bindings/conformance/cases.json");
    if std::env::args().nth(1).as_deref() == Some("--write") {
        let mut file = cases::file();
        let frozen = file.clone();
        for case in file["cases"].as_array_mut().unwrap() {
            let mut runner = run::Runner::new(&frozen);
            for step in case["steps"].as_array_mut().unwrap() {
                match runner.step(step) {
                    Ok(fields) if fields.is_empty() => (),
                    Ok(fields) => {
                        let list = |values: &Vec<f64>| values.iter().map(decimal).collect::<Value>();
                        step["expect"] =
                            fields.iter().map(|(name, values)| (name.clone(), list(values))).collect();
                    }
                    Err((status, message)) => step["error"] = json!({"status": status, "message": message}),
                }
            }
        }
        std::fs::write(&path, text(&file)).unwrap();
        return;
    }
    let file = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    print!("{}", run::report(&file));
}
