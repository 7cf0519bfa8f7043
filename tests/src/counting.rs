//! An allocator that counts. The libraries have allocators of their own that nobody outside can watch; a test that links
//! the code they are made of, with this one, sees what it asks for.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, counting; to be made the `#[global_allocator]` of a test.
#[derive(Debug)]
pub struct Counting;

thread_local! {
    // Each test has a thread of its own.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<isize> = const { Cell::new(0) };
}

impl Counting {
    /// How often this thread has asked for memory.
    pub fn allocations() -> u64 {
        ALLOCATIONS.get()
    }

    /// How many bytes it has asked for and not given back.
    pub fn bytes() -> isize {
        BYTES.get()
    }
}

fn count(asked: usize, given_back: usize) {
    ALLOCATIONS.set(ALLOCATIONS.get() + u64::from(asked > 0));
    BYTES.set(BYTES.get() + asked as isize - given_back as isize);
}

// SAFETY: the system's allocator does the work.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(0, layout.size());
        // SAFETY: passed on.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size, layout.size());
        // SAFETY: passed on.
        unsafe { System.realloc(memory, layout, size) }
    }
}
