use super::*;

fn repaired_text(text: &str) -> (Result<String, String>, Vec<(usize, String)>) {
    let mut left_out = Vec::new();
    let done = repaired(text.as_bytes().into(), &mut left_out);
    let done = done.map(|text| String::from_utf8(text).unwrap());
    let left_out = left_out.into_iter().map(|part| (part.line, part.what));
    (done, left_out.collect())
}

#[test]
fn what_the_parser_knows_stays() {
    let text = "#usda 1.0\ndef Sphere \"s\" {\n double radius = 2\n}\n";
    assert_eq!(repaired_text(text), (Ok(text.into()), Vec::new()));
}

#[test]
fn statements_that_it_refuses_are_left_out() {
    let text = "#usda 1.0\ndef Sphere \"s\" (\n permission = 7\n)\n{\n float a = undefined\n double radius = 2 (\n  x = +\n )\n}\n";
    let (done, left_out) = repaired_text(text);
    assert!(done.unwrap().contains("double radius = 2"));
    let expected = [(3, "permission"), (6, "float a"), (8, "x")];
    assert_eq!(
        left_out,
        expected.map(|(line, what)| (line, what.to_owned()))
    );
}

#[test]
fn what_is_no_text_of_usd_is_refused_with_its_line() {
    let (done, _) = repaired_text("#usda 1.0\ndef Sphere {\n}\n");
    assert_eq!(
        done.unwrap_err(),
        "its line 2 is not understood: \"def Sphere {\""
    );
    let (done, _) = repaired_text("hello");
    assert!(done.is_err());
}

#[test]
fn there_is_an_end_to_it() {
    let mut text = "#usda 1.0\ndef Sphere \"s\" {\n".to_owned();
    for number in 0..1000 {
        text.push_str(&format!(" float a{number} = undefined\n"));
    }
    text.push('}');
    let (done, left_out) = repaired_text(&text);
    assert!(done.is_err());
    assert!(left_out.len() <= MOST_LEFT_OUT + 1);
}
