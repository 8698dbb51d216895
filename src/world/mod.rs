//! The prepared scene: recentred, in Embree, ready for rays.
