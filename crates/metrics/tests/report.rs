//! What stands in a page, and that it stands by itself.

use murano_metrics::{
    heat_map::HeatMap,
    images::Picture,
    report::{Axis, Block, CaptionedPicture, Column, Fact, Gallery, Plot, Point, Report, Series, Table},
    scale::{Scale, Scaling},
    spread::fit_power_law,
};

fn axis(label: &str, scaling: Scaling) -> Axis {
    Axis { label: label.into(), scaling }
}

fn fact(name: &str, value: &str) -> Fact {
    Fact { name: name.into(), value: value.into() }
}

/// Run time against error of six methods, as a refraction benchmark gives them.
fn scatter() -> Plot {
    let method = |index: usize, name: &str| {
        let points = [1, 2, 4, 8, 16, 32].map(|steps| {
            let (time, error) = (0.2 + 0.06 * f64::from(steps) * (1.0 + index as f64 * 0.6), 9.0 / f64::from(steps));
            let wobble = 1.0 + 0.3 * ((index * 7 + steps as usize * 3) % 5) as f64;
            Point { x: time, y: error * wobble / (1.0 + index as f64), title: format!("{steps} steps") }
        });
        Series { name: name.into(), points: points.into(), ..Series::default() }
    };
    let names = ["paper", "binary search", "hierarchy", "secant", "object space", "layers"];
    Plot {
        title: "Run time against error, bunny, n = 1.5".into(),
        caption: "Down and to the left is better. Each method has one point for each number of steps.".into(),
        x: axis("GPU time (ms)", Scaling::Logarithmic),
        y: axis("Mean angle (\u{b0})", Scaling::Logarithmic),
        series: names.iter().enumerate().map(|(index, name)| method(index, name)).collect(),
        pareto_front: true,
    }
}

/// How time grows with triangles, with fitted laws.
fn growth() -> Plot {
    let series = |name: &str, floor: f64, exponent: f64| {
        let x: Vec<f64> = [1e3, 4e3, 16e3, 64e3, 256e3, 1e6].into();
        let y: Vec<f64> = x.iter().map(|x| floor + 2e-5 * x.powf(exponent)).collect();
        let points = x.iter().zip(&y).map(|(&x, &y)| Point { x, y, title: String::new() }).collect();
        Series { name: name.into(), points, line: true, fit: fit_power_law(&x, &y).ok() }
    };
    Plot {
        title: "Time against triangles".into(),
        x: axis("Triangles", Scaling::Logarithmic),
        y: axis("Time (ms)", Scaling::Logarithmic),
        series: vec![series("deform", 0.0, 1.0), series("interface map", 0.4, 0.8)],
        ..Plot::default()
    }
}

fn linear() -> Plot {
    let points = (0..12_u32).map(|frame| Point {
        x: f64::from(frame),
        y: if frame == 7 { f64::NAN } else { 4.0 + f64::from(frame % 4) * 0.3 },
        title: format!("frame {frame}"),
    });
    Plot {
        title: "Time of each frame".into(),
        x: axis("Frame", Scaling::Linear),
        y: axis("Time (ms)", Scaling::Linear),
        series: vec![Series { name: "GPU".into(), points: points.collect(), line: true, fit: None }],
        ..Plot::default()
    }
}

fn gallery() -> Gallery {
    let size = [160, 120];
    let pixels =
        |tint: u8| -> Vec<[u8; 3]> { (0..160 * 120).map(|i| [(i % 160) as u8, (i / 160) as u8 * 2, tint]).collect() };
    let picture = |tint, caption: &str| CaptionedPicture {
        png: Picture::new(size, pixels(tint)).unwrap().to_png().unwrap(),
        caption: caption.into(),
        alt: format!("A ramp of colours, {caption}"),
    };
    let errors: Vec<f32> = (0..160 * 120)
        .map(|i| {
            let (x, y) = ((i % 160) as f32 - 80.0, (i / 160) as f32 - 60.0);
            if x.hypot(y) > 55.0 { f32::NAN } else { 0.002 * (x.hypot(y) / 8.0).exp() }
        })
        .collect();
    let scale = Scale::logarithmic_of(&errors);
    let map = HeatMap { title: "Angle of the exit direction", unit: "\u{b0}", size, values: &errors, scale };
    let heat = CaptionedPicture {
        png: map.draw().unwrap().to_png().unwrap(),
        caption: "Error".into(),
        alt: "Heat map of the angle, rising towards the rim of a disc".into(),
    };
    Gallery {
        caption: "Bunny, n = 1.5".into(),
        pictures: vec![picture(40, "Truth"), picture(60, "Binary search, 8 steps"), heat],
    }
}

fn table() -> Table {
    let columns = ["p50 (\u{b0})", "p95 (\u{b0})", "Wrong status (%)", "FLIP", "GPU (ms)", "Spread (ms)"];
    let row =
        |name: &str, values: [&str; 6]| [name].iter().chain(&values).map(|cell| (*cell).to_owned()).collect::<Vec<_>>();
    Table {
        caption: "Errors and times, 960 x 540, median of 20 frames".into(),
        columns: std::iter::once(Column::text("Method")).chain(columns.map(Column::number)).collect(),
        rows: vec![
            row("paper, 1 step", ["8.41", "31.20", "4.10", "0.221", "0.31", "0.02"]),
            row("binary search, 8 steps", ["0.92", "11.75", "1.32", "0.094", "0.74", "0.03"]),
            row("hierarchy", ["0.11", "2.08", "0.40", "0.031", "12.60", "0.41"]),
        ],
    }
}

fn sample() -> Report {
    let heading = |text: &str| Block::Heading(text.into());
    Report {
        title: "Refraction: run time and error".into(),
        summary: "Six methods over two bodies at two indices, held against the exact tracer.".into(),
        facts: vec![
            fact("Adapter", "llvmpipe (LLVM 19.1.7, 256 bits), Vulkan"),
            fact("Date", "2026-11-22"),
            fact("Version", "0.1.0"),
            fact("Command", "murano bench refraction --models bunny,fox --ior 1.2,1.5 --json out/refraction.json"),
        ],
        blocks: vec![
            heading("Run time against error"),
            Block::Plot(scatter()),
            Block::Plot(growth()),
            Block::Plot(linear()),
            heading("Bunny"),
            Block::Paragraph("The silhouette is left out.".into()),
            Block::Table(table()),
            Block::Gallery(gallery()),
            heading("Limits"),
            Block::Subheading("What was not measured".into()),
            Block::Plot(Plot { title: "Nothing".into(), ..Plot::default() }),
        ],
    }
}

/// The page is kept for a look in a browser.
#[test]
fn a_page_stands_by_itself() {
    let html = sample().to_html();
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.html");
    std::fs::write(&path, &html).unwrap();
    for foreign in ["<script", "<link", "http://", "https://", "url(", "@import", "javascript:"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    for needed in ["prefers-color-scheme: dark", "width=device-width", "<html lang=\"en\">", "default-src 'none'"] {
        assert!(html.contains(needed), "{needed}");
    }
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 3);
    assert_eq!(html.matches("<img ").count(), html.matches(" alt=\"").count());
    assert_eq!(html.matches("href=\"#section-").count(), 3);
    for index in 0..3 {
        assert!(html.contains(&format!("<h2 id=\"section-{index}\">")));
    }
}

#[test]
fn all_text_is_escaped() {
    let evil = "<b onload=\"x\">&'</style></title>";
    let text = || evil.to_owned();
    let plot = Plot {
        title: text(),
        caption: text(),
        x: axis(evil, Scaling::Linear),
        y: axis(evil, Scaling::Linear),
        series: vec![Series {
            name: text(),
            points: vec![Point { x: 1.0, y: 2.0, title: text() }],
            ..Series::default()
        }],
        pareto_front: true,
    };
    let picture = CaptionedPicture { png: vec![1, 2, 3], caption: text(), alt: text() };
    let report = Report {
        title: text(),
        summary: text(),
        facts: vec![fact(evil, evil)],
        blocks: vec![
            Block::Heading(text()),
            Block::Heading(text()),
            Block::Heading(text()),
            Block::Subheading(text()),
            Block::Paragraph(text()),
            Block::Table(Table {
                caption: text(),
                columns: vec![Column::text(evil), Column::number(evil)],
                rows: vec![vec![text(), text()]],
            }),
            Block::Plot(plot),
            Block::Gallery(Gallery { caption: text(), pictures: vec![picture] }),
        ],
    };
    let html = report.to_html();
    assert!(!html.contains("<b "));
    assert_eq!(html.matches("</style>").count(), 1);
    assert_eq!(html.matches("</title>").count(), 2, "of the page and of the point");
    // 3 headings twice, each of the other texts at least once: title twice, table, gallery and plot in several places.
    assert!(html.matches("&lt;b onload=").count() >= 28, "{}", html.matches("&lt;b onload=").count());
}

fn page_of(plot: Plot) -> String {
    Report { blocks: vec![Block::Plot(plot)], ..Report::default() }.to_html()
}

#[test]
fn every_point_with_a_place_has_a_marker_and_every_point_a_row() {
    let html = page_of(scatter());
    assert_eq!(html.matches("<title>").count(), 1 + 36);
    assert_eq!(html.matches("<tr>").count(), 1 + 36);
    let html = page_of(linear());
    assert_eq!(html.matches("<title>").count(), 1 + 11);
    assert_eq!(html.matches("<tr>").count(), 1 + 12);
    assert!(html.contains("1 of 12 points have no place"));
    // The line is broken where there is no value.
    assert_eq!(html.matches("<path class=\"line s0\"").count(), 2 + 1, "two runs and the key");
    assert!(!html.contains("NaN\"") && !html.contains("inf\""), "no coordinate is not a number");
}

#[test]
fn legends_tell_fitted_exponents() {
    let html = page_of(growth());
    assert!(html.contains("<sup>1.00</sup>, R\u{b2} 1.000"));
    assert_eq!(html.matches("class=\"fit s").count(), 2);
}

#[test]
fn the_front_is_drawn_through_the_best_points() {
    let point = |x, y| Point { x, y, title: String::new() };
    let plot = Plot {
        series: vec![
            Series { points: vec![point(1.0, 8.0), point(2.0, 9.0)], ..Series::default() },
            Series { points: vec![point(4.0, 2.0), point(5.0, 2.0)], ..Series::default() },
        ],
        pareto_front: true,
        ..Plot::default()
    };
    assert_eq!(page_of(plot.clone()).matches("<circle class=\"front\"").count(), 2);
    assert!(!page_of(Plot { pareto_front: false, ..plot }).contains("Pareto"));
}

#[test]
fn a_plot_without_values_says_so() {
    let html = page_of(Plot { title: "Nothing".into(), ..Plot::default() });
    assert!(html.contains("No value has a place on these axes.") && !html.contains("<svg"));
}

#[test]
fn rows_have_one_cell_a_column() {
    let rows = vec![vec!["a".into()], vec!["b".into(), "1".into(), "surplus".into()]];
    let table = Table { caption: String::new(), columns: vec![Column::text("T"), Column::number("N")], rows };
    let html = Report { blocks: vec![Block::Table(table)], ..Report::default() }.to_html();
    assert_eq!((html.matches("<th scope=\"row\"").count(), html.matches("<td").count()), (2, 2));
    assert!(!html.contains("surplus"));
}

#[test]
fn a_report_is_data() {
    let json = serde_json::to_value(sample()).unwrap();
    assert_eq!(json["facts"][1]["value"], "2026-11-22");
    assert_eq!(json["blocks"][1]["kind"], "plot");
    assert_eq!(json["blocks"][1]["content"]["x"]["scaling"], "logarithmic");
    let png = json["blocks"][7]["content"]["pictures"][0]["png"].as_str().unwrap();
    assert!(png.starts_with("data:image/png;base64,iVBORw0KGgo"));
}
