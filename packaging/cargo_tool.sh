# To be sourced in the top folder: subcommands of cargo, installed in target/tools where they are missing.
export PATH=$PWD/target/tools/bin:$PATH

cargo_tool() { # cargo_tool NAME VERSION
    cargo "$1" --version >/dev/null 2>&1 && return
    # Without optimisation and line numbers: it is built in a third of the time, and runs for a second.
    CARGO_PROFILE_DEV_DEBUG=false CARGO_TARGET_DIR=target/tools/build cargo install --locked --debug --version "$2" --root target/tools "cargo-$1"
    rm -rf target/tools/build
}
