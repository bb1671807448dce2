//! What the header says that each function returns.

use std::collections::{BTreeMap, BTreeSet};

/// The statuses that any call may return: OK, INVALID_ARGUMENT, NULL_POINTER, STRUCT_SIZE, BUSY.
const ANY: [i32; 5] = [0, -1, -2, -3, -6];

/// By function what it may return.
pub struct Statuses(BTreeMap<String, BTreeSet<i32>>);

impl Statuses {
    pub fn read() -> Self {
        let header =
            std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/include/cylfuse/cylfuse.h"))
                .unwrap();
        let numbers: BTreeMap<&str, i32> = header
            .lines()
            .filter_map(|line| line.strip_prefix("#define CYLFUSE_STATUS_")?.split_once(' '))
            .map(|(name, number)| (name, number.trim_matches(['(', ')']).parse().unwrap()))
            .collect();
        let mut texts = BTreeMap::new();
        let mut comment = "";
        for block in header.split("/**").skip(1) {
            let Some((text, code)) = block.split_once("*/") else { continue };
            comment = if code.contains("CYLFUSE_API") { text } else { comment };
            if let Some(declared) = code.trim_start().strip_prefix("CYLFUSE_API")
                && let Some((before, _)) = declared.split_once('(')
            {
                let name = before.split_whitespace().last().unwrap().trim_start_matches('*');
                let returned = comment.split_once("@return").map_or("", |(_, text)| text);
                texts.insert(name.to_string(), returned);
            }
        }
        assert!(texts.len() > 80, "the header looks different now: {} functions", texts.len());
        let words = |text: &str| {
            text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).map(str::to_string).collect()
        };
        let statuses = texts.iter().map(|(name, text)| {
            let mut all: BTreeSet<i32> = ANY.into();
            let own: Vec<String> = words(text);
            let others = own.iter().filter_map(|word| texts.get(word.as_str()));
            for word in others.flat_map(|text| -> Vec<String> { words(text) }).chain(own.iter().cloned()) {
                all.extend(numbers.get(word.as_str()));
            }
            (name.clone(), all)
        });
        Self(statuses.collect())
    }

    /// Whether the header lists a status for a function.
    pub fn lists(&self, function: &str, status: i32) -> bool {
        self.0.get(function).unwrap_or_else(|| panic!("{function} is not in the header")).contains(&status)
    }

    /// Fails when a function returned what it does not list.
    pub fn check(&self, function: &str, status: i32, text: &str) {
        assert!(
            self.lists(function, status),
            "{function} returned {status} ({text}), which it does not list"
        );
    }
}
