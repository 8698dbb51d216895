use super::*;

#[test]
fn statements_end_where_their_value_does() {
    let end = |text: &str| {
        let (end, value) = statement(text.as_bytes(), 0);
        (text[..end].to_owned(), value.is_some())
    };
    assert_eq!(end("float a = 5\nfloat b"), ("float a = 5".into(), true));
    assert_eq!(end("float a\nfloat b = 1"), ("float a".into(), false));
    assert_eq!(
        end("float3[] a = [(1, 2, 3)] (\n doc = \"]\"\n)\nfloat b"),
        ("float3[] a = [(1, 2, 3)] (\n doc = \"]\"\n)".into(), true)
    );
    assert_eq!(
        end("references = prepend [@a@</b>]\nx"),
        ("references = prepend [@a@</b>]".into(), true)
    );
    assert_eq!(end("r = @a@</b>\nx"), ("r = @a@</b>".into(), true));
}

#[test]
fn nothing_that_ends_too_early_is_followed_beyond_its_end() {
    for text in [
        "a = ",
        "a = [",
        "a = @",
        "a = @x@ <",
        "a = \"\\",
        "a (",
        "=",
        "[",
        "a = <",
        "a = /*",
    ] {
        let (end, _) = statement(text.as_bytes(), 0);
        assert!(end <= text.len(), "{text}");
        assert!(closed(text.as_bytes(), 0) <= text.len());
        assert!(value_end(text.as_bytes(), 0) <= text.len());
    }
}

#[test]
fn lines_are_counted_from_one() {
    assert_eq!(line(b"a\nb\nc", 0), 1);
    assert_eq!(line(b"a\nb\nc", 4), 3);
}
