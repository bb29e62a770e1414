//! The program under the name `analyze-recordings`: [`kinetoscope_program::main`] decides by the name of the call.

fn main() -> std::process::ExitCode {
    kinetoscope_program::main()
}
