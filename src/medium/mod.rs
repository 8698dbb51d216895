//! Participating media (none yet).
