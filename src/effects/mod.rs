//! Which effects a scene and its settings call for, by value.
