//! The command `squirm`.
#![deny(missing_docs)]
#![deny(unsafe_code)]

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
