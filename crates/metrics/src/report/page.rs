//! The page around the plots.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Block, Column, Content, Gallery, Report, Table, data_uri, plot::figure};

const STYLE: &str = include_str!("style.css");

/// Nothing but inline styles and pictures inside the file may be used.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// From this many sections on, a list of them stands at the top.
const SECTIONS_TO_LIST: usize = 3;

pub(super) fn page(report: &Report) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (report.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (report.title) }
                    @if !report.summary.is_empty() { p.summary { (report.summary) } }
                    @if !report.facts.is_empty() {
                        dl.facts {
                            @for fact in &report.facts { div { dt { (fact.name) } dd { (fact.value) } } }
                        }
                    }
                    (contents(report))
                }
                main { (blocks(&report.blocks)) }
            }
        }
    }
}

/// The sections of the page, as links.
fn contents(report: &Report) -> Markup {
    let headings = report.blocks.iter().filter_map(|block| match block {
        Block::Heading(text) => Some(text),
        _ => None,
    });
    html! {
        @if headings.clone().count() >= SECTIONS_TO_LIST {
            nav aria-label="Sections" {
                ul { @for (index, text) in headings.enumerate() { li { a href={ "#" (section_id(index)) } { (text) } } } }
            }
        }
    }
}

fn section_id(index: usize) -> String {
    format!("section-{index}")
}

fn blocks(blocks: &[Block]) -> Markup {
    let both_plots = |a: &Block, b: &Block| matches!((a, b), (Block::Plot(_), Block::Plot(_)));
    let mut sections = 0..blocks.len();
    html! {
        @for group in blocks.chunk_by(both_plots) {
            @match &group[0] {
                Block::Heading(text) => h2 id=(section_id(sections.next().unwrap_or_default())) { (text) },
                Block::Subheading(text) => h3 { (text) },
                Block::Paragraph(text) => p { (text) },
                Block::Table(table) => (table_of(table)),
                Block::Plot(_) => div.plots {
                    @for block in group { @if let Block::Plot(plot) = block { (figure(plot)) } }
                },
                Block::Gallery(gallery) => (gallery_of(gallery)),
            }
        }
    }
}

pub(super) fn table_of(table: &Table) -> Markup {
    // Wide tables scroll by themselves; a region that scrolls must be reachable by the keyboard, and have a name.
    html! {
        div.scroll role="region" tabindex="0" aria-label=(table.caption) {
            table {
                caption { (table.caption) }
                thead { tr { @for column in &table.columns { th scope="col" class=(class(column)) { (column.title) } } } }
                tbody { @for row in &table.rows { tr { (cells(&table.columns, row)) } } }
            }
        }
    }
}

fn cells(columns: &[Column], row: &[String]) -> Markup {
    html! {
        @for (index, column) in columns.iter().enumerate() {
            @let text = row.get(index).map_or("", String::as_str);
            @if index == 0 && column.content == Content::Text {
                th scope="row" { (text) }
            } @else {
                td class=(class(column)) { (text) }
            }
        }
    }
}

fn class(column: &Column) -> &'static str {
    match column.content {
        Content::Text => "text",
        Content::Number => "number",
    }
}

fn gallery_of(gallery: &Gallery) -> Markup {
    html! {
        section.gallery aria-label=(gallery.caption) {
            p.caption { (gallery.caption) }
            div.pictures {
                @for picture in &gallery.pictures {
                    figure {
                        img src=(data_uri(&picture.png)) alt=(picture.alt) loading="lazy";
                        figcaption { (picture.caption) }
                    }
                }
            }
        }
    }
}
