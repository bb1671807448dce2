//! Buffers between pages without access, and a count of the memory that is held.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ptr::null_mut;

/// The allocator of the system, with the bytes that each thread holds.
pub struct Counting;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
    static MOST_HELD: Cell<isize> = const { Cell::new(0) };
}

/// The most that this thread held since [`reset_most_held`].
pub fn most_held() -> isize {
    MOST_HELD.get()
}

pub fn reset_most_held() {
    MOST_HELD.set(held());
}

/// Bytes that this thread has taken and not given back.
pub fn held() -> isize {
    HELD.get()
}

fn count(bytes: isize) {
    // A thread that ends has no count any more.
    let _ = HELD.try_with(|held| {
        held.set(held.get() + bytes);
        MOST_HELD.try_with(|most| most.set(most.get().max(held.get())))
    });
}

// SAFETY: every call goes to the allocator of the system as it is; counting asks for no memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `alloc`.
        let memory = unsafe { System.alloc(layout) };
        if !memory.is_null() {
            count(layout.size() as isize);
        }
        memory
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(memory, layout) }
    }
}

const PAGE: usize = 4096;
const ROOM: usize = 1 << 20;
/// More than the buffers of one call.
const SLABS: usize = 24;
const CANARY: u8 = 0xc5;
const CANARIES: usize = 64;

/// Memory for one buffer, with a page without access at either end.
struct Slab {
    room: *mut u8,
    protection: i32,
    /// Where bytes of [`CANARY`] lie.
    canaries: (usize, usize),
    used: bool,
}

/// Memory for the buffers of a call.
pub struct Arena {
    slabs: Vec<Slab>,
    next: usize,
}

impl Slab {
    fn new() -> Self {
        let size = ROOM + 2 * PAGE;
        let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
        // SAFETY: a new mapping.
        let whole = unsafe { libc::mmap(null_mut(), size, libc::PROT_NONE, flags, -1, 0) };
        assert_ne!(whole, libc::MAP_FAILED);
        let room = unsafe { whole.cast::<u8>().add(PAGE) };
        Self { room, protection: libc::PROT_NONE, canaries: (0, 0), used: false }
    }

    fn protect(&mut self, protection: i32) {
        if self.protection != protection {
            // SAFETY: the mapping of this slab.
            assert_eq!(unsafe { libc::mprotect(self.room.cast(), ROOM, protection) }, 0);
            self.protection = protection;
        }
    }

    /// Whether nothing was written beside the buffer where there is no page to say so.
    fn check(&mut self) {
        if self.protection == libc::PROT_NONE {
            self.protect(libc::PROT_READ);
        }
        let (from, to) = self.canaries;
        for at in from..to {
            let byte = unsafe { self.room.add(at).read() };
            assert_eq!(byte, CANARY, "written {} bytes beside a buffer", (to - at).min(at - from + 1));
        }
    }
}

impl Arena {
    pub fn new() -> Self {
        Self { slabs: (0..SLABS).map(|_| Slab::new()).collect(), next: 0 }
    }

    /// Copies bytes to where the page behind them, or before them, has no access.
    pub fn place(&mut self, bytes: &[u8], at_end: bool) -> *mut u8 {
        assert!(bytes.len() + CANARIES <= ROOM, "{} bytes", bytes.len());
        let slab = &mut self.slabs[self.next];
        self.next += 1;
        slab.protect(libc::PROT_READ | libc::PROT_WRITE);
        let start = if at_end { ROOM - bytes.len() } else { 0 };
        slab.canaries =
            if at_end { (start - CANARIES, start) } else { (bytes.len(), bytes.len() + CANARIES) };
        slab.used = true;
        // SAFETY: the room of the slab.
        unsafe {
            slab.room.add(slab.canaries.0).write_bytes(CANARY, CANARIES);
            let place = slab.room.add(start);
            place.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
            place
        }
    }

    /// Makes the buffer that was placed last one that cannot be written.
    pub fn read_only(&mut self) {
        self.slabs[self.next - 1].protect(libc::PROT_READ);
    }

    /// After a call: checks the surroundings of all buffers and takes the buffers away, which nobody may use any more.
    pub fn release(&mut self, take_away: bool) {
        self.next = 0;
        for slab in self.slabs.iter_mut().filter(|slab| slab.used) {
            slab.check();
            slab.used = false;
            if take_away {
                slab.protect(libc::PROT_NONE);
            }
        }
    }
}
