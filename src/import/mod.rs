//! Files become a scene plus diagnostics.
