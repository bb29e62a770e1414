//! Internal errors: a panic or a failed allocation ends a program with a message and exit code 70.

use crate::standard_output::complain;
use crate::threads::ON_MISSING_THREAD;
use std::any::Any;
use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{self, PanicHookInfo, UnwindSafe};
use std::process::ExitCode;

/// The exit code of an internal error, as in `sysexits.h` (`EX_SOFTWARE`).
pub const INTERNAL_ERROR: u8 = 70;

/// Calls the main function of a program. A panic in any thread is reported as an internal error with the next step; if it ends
/// the program, the exit code is 70 instead of 101. After a failed allocation it is 70 instead of a signal: the standard
/// library reports the size and aborts.
pub fn catch_internal_errors(main: impl FnOnce() -> ExitCode + UnwindSafe) -> ExitCode {
    end_aborts();
    panic::set_hook(Box::new(report_panic));
    panic::catch_unwind(main).unwrap_or_else(|_| ExitCode::from(INTERNAL_ERROR))
}

/// The next step after an abort, which follows the message of the standard library.
#[cfg(unix)]
const ON_ABORT: &[u8] = b"help: if memory was missing, end other programs, or raise the limit of memory (`ulimit -v`); finished \
    recordings are complete, and the same command resumes the others\n";

/// Turns `abort`, by which the standard library ends a program without memory, into the next step and exit code 70.
fn end_aborts() {
    #[cfg(unix)]
    {
        use signal_hook::{consts::SIGABRT, flag, low_level};
        use std::sync::{Arc, atomic::AtomicBool};
        let status = i32::from(INTERNAL_ERROR);
        // SAFETY: the action only calls `write`, which may be called in a handler of signals, with a constant text.
        #[allow(
            unsafe_code,
            reason = "the action of a signal; the standard library has no stable hook for failed allocations"
        )]
        let _ = unsafe {
            low_level::register(SIGABRT, || {
                libc::write(libc::STDERR_FILENO, ON_ABORT.as_ptr().cast(), ON_ABORT.len());
            })
        };
        // Without the handler, only the exit code of an abort differs.
        let _ =
            flag::register_conditional_shutdown(SIGABRT, status, Arc::new(AtomicBool::new(true)));
    }
}

/// The start of the message with which the standard library ends a thread that has started without memory for its signal stack.
const WITHOUT_SIGNAL_STACK: &str = "failed to allocate an alternative stack";

/// Room for the names of functions, bytes: more than those of a program with all of its symbols.
const MEMORY_OF_BACKTRACE: usize = 1 << 30;

fn report_panic(panic: &PanicHookInfo<'_>) {
    let what = message(panic.payload());
    if what.starts_with(WITHOUT_SIGNAL_STACK) {
        complain(&format!("error: not enough memory: {what}\nhelp: {ON_MISSING_THREAD}"), false);
        return;
    }
    let place = panic.location().map(|place| format!(" ({place})")).unwrap_or_default();
    let mut text = format!(
        "error: internal error: {what}{place}\n\
         help: finished recordings are complete, and the same command resumes the others; please report this message with the command and \
         its input"
    );
    // Captured if the developer asks for it with the variable of the standard library, and if there is memory for its names: the library
    // holds a lock while it reads them, for which its own report of a failed allocation would wait without end.
    let has_room = Vec::<u8>::new().try_reserve_exact(MEMORY_OF_BACKTRACE).is_ok();
    let backtrace = if has_room { Backtrace::capture() } else { Backtrace::disabled() };
    if backtrace.status() == BacktraceStatus::Captured {
        text += &format!("\n{backtrace}");
    }
    // A message may contain text of a file.
    complain(&text, false);
}

fn message(payload: &dyn Any) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("unknown")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    #[test]
    fn panic_of_a_program_is_exit_code_70() {
        let code = |code: ExitCode| format!("{code:?}");
        let panics = catch_internal_errors(|| panic!("a test of the message: {}", 1));
        assert_eq!(code(panics), code(ExitCode::from(70)));
        let joins = catch_internal_errors(|| {
            thread::scope(|scope| {
                scope.spawn(|| panic!("a test of the message"));
            });
            ExitCode::SUCCESS
        });
        assert_eq!(code(joins), code(ExitCode::from(70)));
        let control = catch_internal_errors(|| ExitCode::from(4));
        assert_eq!(code(control), code(ExitCode::from(4)));
        drop(panic::take_hook());
    }
}
