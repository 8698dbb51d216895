//! The path loop.
