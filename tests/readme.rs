//! The C program of the README compiles with the commands there and prints what it should.
#![allow(clippy::unwrap_used)]

mod common;

use common::{c_compiler, library, root, run, scratch};
use std::process::Command;

#[test]
fn the_c_program_of_the_readme_runs() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let program = readme.split("```c\n").nth(1).unwrap().split("```").next().unwrap();
    let folder = scratch("readme");
    std::fs::write(folder.join("smallest.c"), program).unwrap();
    run(c_compiler()
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"])
        .arg(root().join("include"))
        .arg(folder.join("smallest.c"))
        .arg(library("libcylfuse.a"))
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(folder.join("smallest")));
    assert_eq!(run(&mut Command::new(folder.join("smallest"))), "radius 0.500000\n");
}
