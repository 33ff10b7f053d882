//! Plots as SVG.
//!
//! Colours and sizes of text come from the style sheet, which knows light from dark and narrow from wide.

use std::fmt::Write;

use maud::{Markup, html};

use super::{Axis, Column, Plot, Point, Series, Table, page::table_of};
use crate::{
    scale::{Scale, scientific, significant},
    spread::pareto_front,
};

/// Size of the drawing, user units.
const SIZE: [f64; 2] = [560.0, 340.0];
/// Room for the ticks' labels: left, top, right, bottom.
const MARGIN: [f64; 4] = [66.0, 12.0, 22.0, 32.0];
/// Size of the area between the axes.
const AREA: [f64; 2] = [SIZE[0] - MARGIN[0] - MARGIN[2], SIZE[1] - MARGIN[1] - MARGIN[3]];

/// The sign of negative numbers, as wide as a digit.
const MINUS: &str = "\u{2212}";

/// Labels that fit along an axis at the largest size of text.
const MOST_TICKS: usize = 6;

/// Colours in the style sheet, and markers here.
const KINDS: usize = 8;
const MARKERS: [&str; KINDS] = [
    "M-5 0A5 5 0 1 0 5 0A5 5 0 1 0-5 0Z",
    "M-4.5-4.5H4.5V4.5H-4.5Z",
    "M0-6L5.5 4H-5.5Z",
    "M0-6.5L6 0L0 6.5L-6 0Z",
    "M0 6L5.5-4H-5.5Z",
    "M-2-6H2V-2H6V2H2V6H-2V2H-6V-2H-2Z",
    "M-6-3L-3-6L0-3L3-6L6-3L3 0L6 3L3 6L0 3L-3 6L-6 3L-3 0Z",
    "M0-6.5L1.8-2H6.2L2.7.9L4 5.5L0 2.8L-4 5.5L-2.7.9L-6.2-2H-1.8Z",
];

/// A plot with its title, legend, caption and the table of its points.
pub(super) fn figure(plot: &Plot) -> Markup {
    let axes = Axes::of(plot);
    let points = || plot.series.iter().flat_map(|series| &series.points);
    let hidden = points().filter(|point| !can_show(plot, point)).count();
    html! {
        figure.plot {
            figcaption { (plot.title) }
            @match &axes {
                Some(axes) => {
                    // Names of quantities can be long: outside of the drawing they wrap, and keep their size.
                    p.axis { @if !plot.y.label.is_empty() { "\u{2191} " (plot.y.label) } }
                    (drawing(plot, axes))
                    p.axis.end { @if !plot.x.label.is_empty() { (plot.x.label) " \u{2192}" } }
                    (legend(plot))
                },
                None => p.empty { "No value has a place on these axes." },
            }
            @if axes.is_some() && hidden > 0 {
                p.note { (hidden) " of " (points().count()) " points have no place on these axes and are not drawn." }
            }
            @if !plot.caption.is_empty() { p.caption { (plot.caption) } }
            @if points().next().is_some() { details { summary { "Values" } (table_of(&values(plot))) } }
        }
    }
}

fn can_show(plot: &Plot, point: &Point) -> bool {
    Scale::can_show(plot.x.scaling, point.x) && Scale::can_show(plot.y.scaling, point.y)
}

struct Axes {
    x: Scale,
    y: Scale,
}

impl Axes {
    /// The axes that show all points that have a place on both.
    fn of(plot: &Plot) -> Option<Self> {
        let shown = || plot.series.iter().flat_map(|series| &series.points).filter(|point| can_show(plot, point));
        Some(Self {
            x: Scale::around(plot.x.scaling, shown().map(|point| point.x))?,
            y: Scale::around(plot.y.scaling, shown().map(|point| point.y))?,
        })
    }

    /// Where a point lies in the area between the axes.
    fn place(&self, x: f64, y: f64) -> [f64; 2] {
        [self.x.position(x) * AREA[0], (1.0 - self.y.position(y)) * AREA[1]]
    }
}

fn drawing(plot: &Plot, axes: &Axes) -> Markup {
    html! {
        svg role="img" aria-label=(summary(plot)) viewBox={ "0 0 " (SIZE[0]) " " (SIZE[1]) } {
            g transform={ "translate(" (MARGIN[0]) " " (MARGIN[1]) ")" } {
                (horizontal_axis(&axes.x))
                (vertical_axis(&axes.y))
                // A nested drawing clips what runs beyond the axes.
                svg width=(AREA[0]) height=(AREA[1]) {
                    @for (index, series) in plot.series.iter().enumerate() { (lines(plot, axes, series, index)) }
                    @if plot.pareto_front { (front(plot, axes)) }
                }
                @for (index, series) in plot.series.iter().enumerate() { (markers(plot, axes, series, index)) }
            }
        }
    }
}

/// The drawing in a sentence.
fn summary(plot: &Plot) -> String {
    let names: Vec<&str> = plot.series.iter().map(|series| series.name.as_str()).collect();
    format!(
        "{}: {} against {}, for {}. The values follow as a table.",
        plot.title,
        plot.y.label,
        plot.x.label,
        names.join(", ")
    )
}

fn horizontal_axis(scale: &Scale) -> Markup {
    let at = |value: f64| number(scale.position(value) * AREA[0]);
    html! {
        @for value in scale.minor_ticks() { line.minor x1=(at(value)) x2=(at(value)) y2=(AREA[1]) {} }
        @for value in scale.ticks(MOST_TICKS) {
            line.major x1=(at(value)) x2=(at(value)) y2=(AREA[1]) {}
            text.tick x=(at(value)) y=(AREA[1]) dy="1.35em" text-anchor="middle" { (tick_label(value)) }
        }
        line.axis x2=(AREA[0]) y1=(AREA[1]) y2=(AREA[1]) {}
    }
}

fn vertical_axis(scale: &Scale) -> Markup {
    let at = |value: f64| number((1.0 - scale.position(value)) * AREA[1]);
    html! {
        @for value in scale.minor_ticks() { line.minor y1=(at(value)) y2=(at(value)) x2=(AREA[0]) {} }
        @for value in scale.ticks(MOST_TICKS) {
            line.major y1=(at(value)) y2=(at(value)) x2=(AREA[0]) {}
            text.tick x="-8" y=(at(value)) dy="0.35em" text-anchor="end" { (tick_label(value)) }
        }
        line.axis y2=(AREA[1]) {}
    }
}

/// The line that joins a series, broken where a point has no place, and that of its fit.
fn lines(plot: &Plot, axes: &Axes, series: &Series, index: usize) -> Markup {
    let runs = series.points.split(|point| !can_show(plot, point)).filter(|run| series.line && run.len() > 1);
    html! {
        @for run in runs {
            path class={ "line s" (index % KINDS) } d=(path(run.iter().map(|point| axes.place(point.x, point.y)))) {}
        }
        @if let Some(law) = &series.fit {
            @let xs = fitted_over(plot, series);
            @let curve: Vec<_> = xs.iter().map(|x| axes.place(*x, law.at(*x))).collect();
            @if curve.iter().flatten().all(|c| c.is_finite()) {
                path class={ "fit s" (index % KINDS) } d=(path(curve.into_iter())) {}
            }
        }
    }
}

/// Abscissae along the drawn points of a series, evenly spread in ratio.
fn fitted_over(plot: &Plot, series: &Series) -> Vec<f64> {
    const STEPS: u32 = 32;
    let shown = || series.points.iter().filter(|point| can_show(plot, point) && point.x > 0.0).map(|point| point.x);
    let (Some(from), Some(to)) = (shown().reduce(f64::min), shown().reduce(f64::max)) else { return Vec::new() };
    (0..=STEPS).map(|step| from * (to / from).powf(f64::from(step) / f64::from(STEPS))).collect()
}

fn markers(plot: &Plot, axes: &Axes, series: &Series, index: usize) -> Markup {
    html! {
        g class={ "mark s" (index % KINDS) } {
            @for point in series.points.iter().filter(|point| can_show(plot, point)) {
                @let [x, y] = axes.place(point.x, point.y);
                path transform={ "translate(" (number(x)) " " (number(y)) ")" } d=(marker(index)) {
                    title { (hover_title(plot, series, point)) }
                }
            }
        }
    }
}

/// Markers go once more round among the colours after each round, so that 64 series differ.
fn marker(index: usize) -> &'static str {
    MARKERS[(index + index / KINDS) % KINDS]
}

fn hover_title(plot: &Plot, series: &Series, point: &Point) -> String {
    let mut text = series.name.clone();
    if !point.title.is_empty() {
        text = format!("{text}, {}", point.title);
    }
    let value = |axis: &Axis, value| format!("\n{}: {}", axis.label, significant(value, 4));
    text + &value(&plot.x, point.x) + &value(&plot.y, point.y)
}

/// The Pareto front as stairs through its points, each of them ringed: below the stairs lies no point.
fn front(plot: &Plot, axes: &Axes) -> Markup {
    let shown = plot.series.iter().flat_map(|series| &series.points).filter(|point| can_show(plot, point));
    let points: Vec<[f64; 2]> = shown.map(|point| [point.x, point.y]).collect();
    let places: Vec<[f64; 2]> = pareto_front(&points).iter().map(|&i| axes.place(points[i][0], points[i][1])).collect();
    let mut stairs = Vec::new();
    if let (Some(first), Some(last)) = (places.first(), places.last()) {
        stairs.push([first[0], 0.0]);
        stairs.push(*first);
        stairs.extend(places.windows(2).flat_map(|pair| [[pair[1][0], pair[0][1]], pair[1]]));
        stairs.push([AREA[0], last[1]]);
    }
    html! {
        path.front d=(path(stairs.into_iter())) {}
        @for [x, y] in &places { circle.front cx=(number(*x)) cy=(number(*y)) r="9" {} }
    }
}

fn legend(plot: &Plot) -> Markup {
    html! {
        ul.legend {
            @for (index, series) in plot.series.iter().enumerate() {
                li {
                    svg.key viewBox="-14 -8 28 16" aria-hidden="true" {
                        @if series.line { path class={ "line s" (index % KINDS) } d="M-14 0H14" {} }
                        g class={ "mark s" (index % KINDS) } { path d=(marker(index)) {} }
                    }
                    span {
                        (series.name)
                        @if let Some(law) = &series.fit {
                            span.law {
                                " \u{221d} x" sup { (format!("{:.2}", law.exponent).replace('-', MINUS)) } ", R\u{b2} " (format!("{:.3}", law.r2))
                            }
                        }
                    }
                }
            }
            @if plot.pareto_front {
                li {
                    svg.key viewBox="-14 -8 28 16" aria-hidden="true" {
                        path.front d="M-14-6H0V6H14" {}
                    }
                    span { "Pareto front" }
                }
            }
        }
    }
}

/// All points of a plot; their titles only if there are any.
fn values(plot: &Plot) -> Table {
    let points = || plot.series.iter().flat_map(|series| series.points.iter().map(move |point| (series, point)));
    let titled = points().any(|(_, point)| !point.title.is_empty());
    let row = |(series, point): (&Series, &Point)| {
        let title = titled.then(|| point.title.clone());
        let numbers = [point.x, point.y].map(|value| significant(value, 4));
        std::iter::once(series.name.clone()).chain(title).chain(numbers).collect()
    };
    let title = titled.then(|| Column::text("Point"));
    let numbers = [Column::number(&plot.x.label), Column::number(&plot.y.label)];
    Table {
        caption: format!("{}: values", plot.title),
        columns: std::iter::once(Column::text("Series")).chain(title).chain(numbers).collect(),
        rows: points().map(row).collect(),
    }
}

/// A polyline through places.
fn path(places: impl Iterator<Item = [f64; 2]>) -> String {
    let mut d = String::new();
    for [x, y] in places {
        let command = if d.is_empty() { 'M' } else { 'L' };
        // Writing to a string cannot fail.
        let _ = write!(d, "{command}{} {}", number(x), number(y));
    }
    d
}

/// A coordinate to a twentieth of a pixel.
fn number(coordinate: f64) -> String {
    significant((coordinate * 10.0).round() / 10.0, 6)
}

/// A round value as people write it: `0.01`, `2000`, `10⁻⁵`, `2·10⁶`.
fn tick_label(value: f64) -> String {
    const LEAST_POWER: f64 = 1e5;
    let plain = if value.abs() < LEAST_POWER { significant(value, 5) } else { scientific(value, 5) };
    let Some((mantissa, exponent)) = plain.split_once('e') else { return plain.replace('-', MINUS) };
    let raised: String = exponent.chars().map(superscript).collect();
    match mantissa {
        "1" => format!("10{raised}"),
        _ => format!("{}\u{b7}10{raised}", mantissa.replace('-', MINUS)),
    }
}

fn superscript(character: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    character.to_digit(10).map_or('\u{207b}', |digit| DIGITS[digit as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scale::Scaling;

    #[test]
    fn values_as_people_write_them() {
        for (value, text) in [
            (0.01, "0.01"),
            (2000.0, "2000"),
            (1e-5, "10⁻⁵"),
            (2e6, "2·10⁶"),
            (100000.0, "10⁵"),
            (-0.5, "\u{2212}0.5"),
            (1e12, "10¹²"),
        ] {
            assert_eq!(tick_label(value), text);
        }
    }

    #[test]
    fn sixty_four_series_differ() {
        let looks: std::collections::HashSet<_> = (0..64).map(|i| (i % KINDS, marker(i))).collect();
        assert_eq!(looks.len(), 64);
    }

    #[test]
    fn points_lie_where_their_values_say() {
        let axis = |scaling| Axis { label: String::new(), scaling };
        let points = [(1.0, 2.0), (100.0, 4.0), (10.0, 3.0)].map(|(x, y)| Point { x, y, title: String::new() });
        let plot = Plot {
            x: axis(Scaling::Logarithmic),
            y: axis(Scaling::Linear),
            series: vec![Series { points: points.to_vec(), ..Series::default() }],
            ..Plot::default()
        };
        let axes = Axes::of(&plot).unwrap();
        let [first, last, middle] = points.map(|point| axes.place(point.x, point.y));
        for axis in 0..2 {
            assert!((middle[axis] - 0.5 * (first[axis] + last[axis])).abs() < 1e-9);
            assert!(first[axis].min(last[axis]) > 5.0 && first[axis].max(last[axis]) < AREA[axis] - 5.0);
        }
        // Right is more, and up is more.
        assert!(first[0] < last[0] && first[1] > last[1]);
    }
}
