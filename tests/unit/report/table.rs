use crate::report::{Axis, Cell, Column, Plot, Point, Series, Table};

#[test]
fn points_keep_all_digits() {
    let plot = Plot {
        x: Axis::log("time", "s"),
        y: Axis::log("error", "%"),
        series: vec![Series::new(
            "cornell, \"seed\" 1",
            vec![
                Point::new(0.1, 1.0 / 3.0).labelled("1 sample"),
                Point::new(2.0, f64::NAN).spread(0.5, f64::INFINITY),
            ],
        )],
        ..Plot::default()
    };
    assert_eq!(
        plot.csv(),
        "series,time (s),error (%),low,high,label\r\n\
             \"cornell, \"\"seed\"\" 1\",0.1,0.3333333333333333,,,1 sample\r\n\
             \"cornell, \"\"seed\"\" 1\",2,NaN,0.5,inf,\r\n"
    );
}

#[test]
fn tables_keep_all_digits() {
    let table = Table {
        columns: vec![Column::new("measure"), Column::new("value")],
        rows: vec![vec![Cell::text("a\nb"), Cell::number(1.0 / 3.0)]],
        ..Table::default()
    };
    assert_eq!(
        table.csv(),
        "measure,value\r\n\"a\nb\",0.3333333333333333\r\n"
    );
}

#[test]
fn columns_stand_below_their_names() {
    let cells = |a: &str, b: &str| vec![Cell::text(a), Cell::shown(1.0, b)];
    let shown = Table {
        columns: vec![Column::new("effect"), Column::new("costs")],
        rows: vec![cells("lamps", "1 s"), cells("a long\nname", "-20 ms")],
        ..Table::default()
    };
    assert_eq!(
        shown.text(),
        "effect         costs\nlamps            1 s\na long\\nname  -20 ms\n"
    );
}
