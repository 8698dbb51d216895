//! Cameras: from a film position to a ray.
