//! The C programs of the README and of the page on scenes compile and print what they should.
#![allow(clippy::unwrap_used)]

mod common;

use common::{c_compiler, library, root, run, scratch};
use std::process::Command;

/// The first block of C in a document.
fn program(document: &str) -> String {
    let text = std::fs::read_to_string(root().join(document)).unwrap();
    text.split("```c\n").nth(1).unwrap().split("```").next().unwrap().to_owned()
}

/// Compiles a program as the README says, and gives what it prints.
fn output_of(name: &str, program: &str) -> String {
    let folder = scratch(name);
    std::fs::write(folder.join("program.c"), program).unwrap();
    run(c_compiler()
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"])
        .arg(root().join("include"))
        .arg(folder.join("program.c"))
        .arg(library("libcylfuse.a"))
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(folder.join("program")));
    run(&mut Command::new(folder.join("program")))
}

#[test]
fn the_c_program_of_the_readme_runs() {
    assert_eq!(output_of("readme", &program("README.md")), "radius 0.500000\n");
}

/// Calls the function of the page with a standing can of radius 0.1 at 1 m before a wall, bright before dark.
const CALLER: &str = "
#include <math.h>
int main(void)
{
    static uint16_t depth[640 * 480];
    static uint8_t image[640 * 480];
    for (int k = 0; k < 640 * 480; k++) {
        double x = (k % 640 - 319.5) / 570.0, y = (k / 640 - 239.5) / 570.0;
        double root = 1.0 - (1.0 + x * x) * (1.0 - 0.01);
        int can = root > 0.0 && fabs(y) < 0.3;
        depth[k] = (uint16_t)(1000.0 * (can ? (1.0 - sqrt(root)) / (1.0 + x * x) : 1.5) + 0.5);
        image[k] = can ? 200 : 50;
    }
    return print_cylinders(depth, image);
}
";

#[test]
fn the_c_program_of_the_page_on_scenes_finds_a_can() {
    let printed = output_of("scene", &(program("docs/segment-a-scene.md") + CALLER));
    let radius = printed.strip_prefix("1: radius ").and_then(|rest| rest.split(',').next()).unwrap();
    assert!((radius.parse::<f64>().unwrap() - 0.1).abs() < 0.001, "{printed}");
    assert_eq!(printed.lines().count(), 1, "{printed}");
}
