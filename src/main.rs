//! The `sundog` program.

use sundog::ffi::memory::Telling;

#[global_allocator]
static MEMORY: Telling = Telling(sundog::cli::memory_used_up);

fn main() -> ! {
    sundog::cli::leave(sundog::cli::main())
}
