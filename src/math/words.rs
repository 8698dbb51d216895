//! Counts in words.

/// `1 triangle`, `2 triangles`, `1.5 samples`; the count as it is written.
pub fn counted(count: impl std::fmt::Display, one: &str, many: &str) -> String {
    let count = count.to_string();
    let noun = if count == "1" { one } else { many };
    format!("{count} {noun}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_many() {
        assert_eq!(counted(0, "mesh", "meshes"), "0 meshes");
        assert_eq!(counted(1, "mesh", "meshes"), "1 mesh");
        assert_eq!(counted(2, "mesh", "meshes"), "2 meshes");
        assert_eq!(counted(1.5, "sample", "samples"), "1.5 samples");
        assert_eq!(counted("1 000", "sample", "samples"), "1 000 samples");
    }
}
