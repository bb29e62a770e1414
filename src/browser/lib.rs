//! The engine as a module of a page (`wasm32-unknown-unknown`): ten functions that pass bytes, and neither physics nor a formula.
//!
//! The page writes a text or a claim to [`input`], calls a function, and reads the answer, JSON or bytes, from [`output`]. A call that
//! traps leaves the message of a panic there; without a message, the memory was not sufficient.
//!
//! # Safety
//! - `no_mangle`: no other function of the program has one of these names, because the module is linked as a whole.

#![allow(unsafe_code)]

pub mod engine;
mod sink;

use engine::{Answer, Engine, Status};
use std::cell::RefCell;
use std::panic;

thread_local! {
    static ENGINE: RefCell<Engine> = RefCell::new(Engine::default());
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

fn answer(question: impl FnOnce(&mut Engine, &[u8]) -> Answer) -> u32 {
    put(Vec::new());
    panic::set_hook(Box::new(|panic| put(panic.to_string().into_bytes())));
    let Answer { status, bytes } =
        INPUT.with_borrow(|input| ENGINE.with_borrow_mut(|engine| question(engine, input)));
    put(bytes);
    status as u32
}

fn put(bytes: Vec<u8>) {
    OUTPUT.with_borrow_mut(|output| *output = bytes);
}

/// Memory for so many bytes of the next question; null if there are none left.
#[unsafe(no_mangle)]
pub extern "C" fn input(bytes: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        if input.try_reserve_exact(bytes).is_err() {
            return std::ptr::null_mut();
        }
        input.resize(bytes, 0);
        input.as_mut_ptr()
    })
}

/// The place of the answer in the memory (upper half) and its number of bytes (lower half).
#[unsafe(no_mangle)]
pub extern "C" fn output() -> u64 {
    OUTPUT.with_borrow(|output| (output.as_ptr() as u64) << 32 | output.len() as u64)
}

/// The versions of the program, of the messages and of each model's physics.
#[unsafe(no_mangle)]
pub extern "C" fn version() -> u32 {
    answer(|_, _| engine::version())
}

/// The runs of the manifest in the input, or its errors.
#[unsafe(no_mangle)]
pub extern "C" fn plan() -> u32 {
    answer(Engine::plan)
}

/// Starts a planned run.
#[unsafe(no_mangle)]
pub extern "C" fn start(run: usize) -> u32 {
    answer(|engine, _| engine.start(run))
}

/// Starts the run of the claim in the input, whose messages are compared and not kept.
#[unsafe(no_mangle)]
pub extern "C" fn verify() -> u32 {
    answer(Engine::verify)
}

/// Advances the run by at most so many steps or events, and at most to its next frame.
#[unsafe(no_mangle)]
pub extern "C" fn advance(budget: u32) -> u32 {
    answer(|engine, _| engine.advance(u64::from(budget)))
}

/// The state of the newest frame, row by row as the manifest's model declares the columns, as 64-bit numbers.
#[unsafe(no_mangle)]
pub extern "C" fn columns() -> u32 {
    answer(|engine, _| engine.columns())
}

/// The metrics of the run that has ended.
#[unsafe(no_mangle)]
pub extern "C" fn metrics() -> u32 {
    answer(|engine, _| engine.metrics())
}

/// The recording of the run that has ended, not compressed.
#[unsafe(no_mangle)]
pub extern "C" fn recording() -> u32 {
    answer(|engine, _| engine.recording())
}

/// The status of a call, as the page receives it.
const _: () = assert!(Status::Working as u32 == 0 && Status::Failed as u32 == 3);
