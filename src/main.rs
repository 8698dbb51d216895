//! The `sundog` program.

fn main() -> std::process::ExitCode {
    sundog::cli::main()
}
