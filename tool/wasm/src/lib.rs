//! The engine as WebAssembly: [`home`] links the blocks and plants of this repository, and three exported functions
//! pass a request in and the answer out.
//!
//! The page calls [`room`] with the length of the request in bytes, writes the request (JSON, UTF-8) to the returned
//! address, calls [`message`], which returns the length of the answer, and reads the answer at the address returned by
//! [`answer`]. Nothing is imported.

// The exported functions are found by name, so they need `#[unsafe(no_mangle)]`: the only unsafe code here.
#![cfg_attr(target_family = "wasm", allow(unsafe_code))]

pub mod home;

use home::Linked;
use std::cell::RefCell;
use tool::Engine;

struct Page {
    engine: Engine<Linked>,
    request: Vec<u8>,
    answer: String,
}

thread_local! {
    static PAGE: RefCell<Page> =
        RefCell::new(Page { engine: Engine::new(Linked::new()), request: Vec::new(), answer: String::new() });
}

/// Makes room for a request of `length` bytes and returns the address to write it to.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn room(length: usize) -> usize {
    PAGE.with_borrow_mut(|page| {
        page.request.clear();
        page.request.resize(length, 0);
        page.request.as_ptr().addr()
    })
}

/// Answers the request and returns the length of the answer in bytes.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn message() -> usize {
    PAGE.with_borrow_mut(|page| {
        let request = std::mem::take(&mut page.request);
        page.answer = page.engine.message(&String::from_utf8_lossy(&request));
        page.answer.len()
    })
}

/// The address of the last answer, valid until the next request.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn answer() -> usize {
    PAGE.with_borrow(|page| page.answer.as_ptr().addr())
}
