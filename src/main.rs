//! The `gable` command: arguments in, exit code out.

use std::process::ExitCode;

fn main() -> ExitCode {
    gable::cli::main()
}
