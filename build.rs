//! The soname of the shared library, the facts that `cylfuse_build_info` reports, and the commit for `cylfuse bench`.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=CYLFUSE_BUILD_INFO={}", build_info());
    if env::var_os("CARGO_FEATURE_BENCH").is_some() {
        // A commit moves the log of HEAD.
        if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
            println!("cargo::rerun-if-changed={log}");
        }
        let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".into());
        println!("cargo::rustc-env=CYLFUSE_COMMIT={commit}");
    }
    let variable = |name: &str| env::var(name).unwrap_or_default();
    // cargo-c turns the feature "capi" on and sets the soname itself.
    if variable("CARGO_CFG_TARGET_OS") == "linux" && env::var_os("CARGO_FEATURE_CAPI").is_none() {
        let (major, minor) = (variable("CARGO_PKG_VERSION_MAJOR"), variable("CARGO_PKG_VERSION_MINOR"));
        // Before 1.0 a minor version may break the interface.
        let version = if major == "0" { format!("0.{minor}") } else { major };
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libcylfuse.so.{version}");
    }
}

fn build_info() -> String {
    let variable = |name: &str| env::var(name).unwrap_or_else(|_| "unknown".into());
    let compiler = Command::new(variable("RUSTC")).arg("--version").output();
    let compiler = compiler.map_or_else(
        |_| "unknown compiler".into(),
        |output| String::from_utf8_lossy(&output.stdout).trim().to_string(),
    );
    let features = match variable("CARGO_CFG_FEATURE") {
        features if features.is_empty() || features == "unknown" => "none".into(),
        features => features,
    };
    format!(
        "cylfuse {}, {}, {}, {compiler}, features: {features}",
        variable("CARGO_PKG_VERSION"),
        variable("TARGET"),
        variable("PROFILE"),
    )
}

/// What git prints; `None` outside of a checkout.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_string())
}
