//! Measurements as one HTML page: facts, tables, plots and pictures.
//!
//! A [`Report`] is a plain value. [`Report::to_html`] writes it as one file that needs no other, no script and no
//! network: styles, drawings (SVG) and pictures (data URIs) are inside, and its content security policy forbids
//! everything else. It follows the reader's choice of light or dark, fits a telephone, and says in text and tables what
//! it shows in pictures. All text is escaped.
//!
//! ```text
//! Report -- title, summary, facts (adapter, date, version, command)
//!   Block::Heading, Subheading, Paragraph
//!   Block::Table    columns of text or of numbers
//!   Block::Plot     scatter or lines, linear or logarithmic axes, fitted power laws, Pareto front; neighbours share a row
//!   Block::Gallery  pictures side by side
//! ```

mod page;
mod plot;

use base64::{Engine, engine::general_purpose::STANDARD};
use serde::{Serialize, Serializer};

use crate::{scale::Scaling, spread::PowerLaw};

/// A page of measurements.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// What was measured and what came out, below the title; left out if empty.
    pub summary: String,
    /// Under what conditions it was measured.
    pub facts: Vec<Fact>,
    /// The page from top to bottom.
    pub blocks: Vec<Block>,
}

/// A condition of a measurement: adapter, date, version, command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fact {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: String,
}

/// A part of a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", content = "content", rename_all = "snake_case")]
pub enum Block {
    /// Begins a section; listed at the top of the page.
    Heading(String),
    /// Begins a part of a section.
    Subheading(String),
    /// Running text.
    Paragraph(String),
    /// Figures by rows and columns.
    Table(Table),
    /// A drawing of figures. Neighbouring plots stand side by side where the page is wide enough.
    Plot(Plot),
    /// Pictures side by side.
    Gallery(Gallery),
}

/// Figures by rows and columns.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Table {
    /// What the table shows.
    pub caption: String,
    /// The columns; if the first holds text, it names the rows.
    pub columns: Vec<Column>,
    /// The rows, one cell a column; missing cells are empty, surplus ones are left out.
    pub rows: Vec<Vec<String>>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Its title, with the unit.
    pub title: String,
    /// What it holds.
    pub content: Content,
}

/// What the cells of a column hold, and so how they are aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// Words, from the left.
    Text,
    /// Numbers, to the right, digits of equal width.
    Number,
}

impl Column {
    /// A column of words.
    pub fn text(title: impl Into<String>) -> Self {
        Self { title: title.into(), content: Content::Text }
    }

    /// A column of numbers.
    pub fn number(title: impl Into<String>) -> Self {
        Self { title: title.into(), content: Content::Number }
    }
}

/// A drawing of one quantity against another.
///
/// Points that have no place on an axis (not finite, or not above zero on a logarithmic one) are not drawn; the page
/// says how many, and lists all points in a table below the plot.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plot {
    /// What the plot shows.
    pub title: String,
    /// What to see in it, below the plot; left out if empty.
    pub caption: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The series; the first 64 differ in colour or marker.
    pub series: Vec<Series>,
    /// Whether to draw the Pareto front over the points of all series, where less is better on both axes.
    pub pareto_front: bool,
}

/// An axis of a plot.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Axis {
    /// The quantity, with its unit.
    pub label: String,
    /// How values are spread over it.
    pub scaling: Scaling,
}

/// Points that belong together.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Its points, in the order in which a line joins them.
    pub points: Vec<Point>,
    /// Whether a line joins the points.
    pub line: bool,
    /// A law fitted to the points: drawn, and its exponent told in the legend.
    pub fit: Option<PowerLaw>,
}

/// A point of a plot.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Point {
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// What it is, shown under the pointer and in the table; may be empty.
    pub title: String,
}

/// Pictures side by side.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Gallery {
    /// What the pictures show together.
    pub caption: String,
    /// The pictures.
    pub pictures: Vec<CaptionedPicture>,
}

/// A picture with its caption.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CaptionedPicture {
    /// A PNG file; serialised as a data URI.
    #[serde(serialize_with = "serialize_data_uri")]
    pub png: Vec<u8>,
    /// What it is.
    pub caption: String,
    /// What it shows, for those who do not see it.
    pub alt: String,
}

impl Report {
    /// The page as one HTML file.
    pub fn to_html(&self) -> String {
        page::page(self).into_string()
    }
}

fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

fn serialize_data_uri<S: Serializer>(png: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&data_uri(png))
}
