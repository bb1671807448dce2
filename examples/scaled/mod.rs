//! Judged constants, scaled one after the other, and the rows of tables on how much each of them matters.

use cylfuse::constant::Constant;

/// Those constants whose names contain one of the words, or all where there are no words. A word that no name contains stops the program.
pub fn constants(mut all: Vec<Constant>, words: &[String]) -> Vec<Constant> {
    for word in words {
        if !all.iter().any(|constant| constant.name.contains(word)) {
            eprintln!(
                "No constant has {word} in its name: write a part of one, such as score:: or REACH, or an option."
            );
            std::process::exit(2);
        }
    }
    all.retain(|constant| words.is_empty() || words.iter().any(|word| constant.name.contains(word)));
    all
}

/// What something comes to while a constant is so many times as large.
pub fn with_scaled<T>(constant: Constant, factor: f64, measured: impl FnOnce() -> T) -> T {
    constant.scale(factor);
    let measured = measured();
    Constant::reset();
    measured
}

/// Its module and its name, without what most have in common.
pub fn name(constant: &Constant) -> &'static str {
    constant.name.trim_start_matches("cylfuse::").trim_start_matches("detection::")
}

/// A row of a table: name, value to four digits, unit, and some columns.
pub fn row(constant: &Constant, columns: &[String]) -> String {
    let value: f64 = format!("{:.3e}", constant.value).parse().unwrap();
    format!("| {} | {value} | {} | {} |", name(constant), constant.unit, columns.join(" | "))
}
