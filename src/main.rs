//! `run-experiment`: arguments to exit code, nothing else.

fn main() {}
