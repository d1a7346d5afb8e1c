//! The `earmark` program. `cli` is the only place that prints, reads arguments or ends the process.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
