//! Lights: sample, pdf, evaluate; the light tree.
