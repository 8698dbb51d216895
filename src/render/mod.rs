//! The schedule: passes, tiles, threads, when to stop.
