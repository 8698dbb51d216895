//! Image differences and reports.
