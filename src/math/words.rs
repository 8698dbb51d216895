//! Counts in words.

/// `1 triangle`, `2 triangles`.
pub fn counted(count: usize, one: &str, many: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        n => format!("{n} {many}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_many() {
        assert_eq!(counted(0, "mesh", "meshes"), "0 meshes");
        assert_eq!(counted(1, "mesh", "meshes"), "1 mesh");
        assert_eq!(counted(2, "mesh", "meshes"), "2 meshes");
    }
}
