//! Pictures of scalar maps with the scale of their colours printed in.
//!
//! Colours are those of viridis (Smith, van der Walt and Firing 2015, matplotlib), which ascends evenly in lightness and
//! is told apart by the colour-blind too. Grey, which viridis does not contain, marks what was not compared.

mod canvas;

use canvas::{Canvas, Lettering};

use crate::{
    MetricsError,
    error::{area, expect_len},
    images::Picture,
    scale::{Scale, significant},
};

/// The colour of values that are NaN: not compared.
pub const NOT_COMPARED: [u8; 3] = [190, 190, 194];

const PANEL: [u8; 3] = [24, 26, 31];
const INK: [u8; 3] = [232, 234, 237];

/// Maps whose longer side is below this are magnified by a whole number, so that text does not dwarf them.
const LEAST_SIDE: u32 = 320;

/// A scalar map to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct HeatMap<'a> {
    /// What the values are, printed above the map.
    pub title: &'a str,
    /// Their unit, printed after the title; nothing is printed if empty.
    pub unit: &'a str,
    /// Width and height of the map.
    pub size: [u32; 2],
    /// One value a pixel, row 0 at the top; NaN is drawn in [`NOT_COMPARED`], what lies beyond the scale in the colour
    /// of its end.
    pub values: &'a [f32],
    /// The values at the ends of the colour bar, and how colours are spread between.
    pub scale: Scale,
}

/// The colour of a value: viridis from the lower to the upper end of the scale, [`NOT_COMPARED`] for NaN.
pub fn colour(scale: &Scale, value: f64) -> [u8; 3] {
    if value.is_nan() { NOT_COMPARED } else { colour_at(scale.position(value)) }
}

fn colour_at(position: f64) -> [u8; 3] {
    colorous::VIRIDIS.eval_continuous(position.clamp(0.0, 1.0)).into_array()
}

impl HeatMap<'_> {
    /// Draws the map, its title, a bar of the scale's colours with ticks, and a key for what was not compared.
    ///
    /// The ticks at the ends say `<` or `>` if values lie beyond. The font has the characters of Latin-1; others are
    /// drawn as `?`.
    ///
    /// # Errors
    /// [`MetricsError::Length`] if there is not one value a pixel, [`MetricsError::Unfit`] if the map is empty or the
    /// picture would be too large.
    pub fn draw(&self) -> Result<Picture, MetricsError> {
        expect_len("the values of the heat map", self.values.len(), area(self.size))?;
        let longer = self.size[0].max(self.size[1]);
        if self.size.contains(&0) || longer > 1 << 15 {
            let need = "give sides from 1 to 32768";
            return Err(MetricsError::Unfit { what: "a heat map", size: self.size, need });
        }
        let layout = Layout::of(self);
        let mut canvas = Canvas::new(layout.size, PANEL, layout.lettering);
        for (line, text) in layout.title.iter().enumerate() {
            canvas.text(layout.left, layout.margin + line as u32 * layout.text_height, text, INK);
        }
        self.draw_map(&mut canvas, &layout);
        self.draw_bar(&mut canvas, &layout);
        if self.values.iter().any(|value| value.is_nan()) {
            let side = layout.text_height * 5 / 8;
            canvas.rectangle([layout.left, layout.key_top + (layout.text_height - side) / 2], [side; 2], NOT_COMPARED);
            canvas.text(layout.left + side * 3 / 2, layout.key_top, "not compared", INK);
        }
        canvas.into_picture()
    }

    fn draw_map(&self, canvas: &mut Canvas, layout: &Layout) {
        let [left, top] = layout.map_at;
        for (index, value) in self.values.iter().enumerate() {
            let (x, y) = (index as u32 % self.size[0], index as u32 / self.size[0]);
            let corner = [left + x * layout.zoom, top + y * layout.zoom];
            canvas.rectangle(corner, [layout.zoom; 2], colour(&self.scale, f64::from(*value)));
        }
    }

    fn draw_bar(&self, canvas: &mut Canvas, layout: &Layout) {
        let (left, top, width) = (layout.left, layout.bar_top, layout.inner_width);
        for x in 0..width {
            let position = (f64::from(x) + 0.5) / f64::from(width);
            canvas.rectangle([left + x, top], [1, layout.bar_height], colour_at(position));
        }
        let mut free_from = 0;
        for (value, text) in self.bar_labels(layout.inner_width / (layout.lettering.advance() * 9)) {
            let x = left + (self.scale.position(value) * f64::from(width - 1)).round() as u32;
            let text_width = layout.lettering.advance() * text.chars().count() as u32;
            let start =
                x.saturating_sub(text_width / 2).clamp(left, (left + width).saturating_sub(text_width).max(left));
            canvas.rectangle([x, top + layout.bar_height], [1, layout.tick], INK);
            if start >= free_from {
                canvas.text(start, top + layout.bar_height + layout.tick, &text, INK);
                free_from = start + text_width + layout.lettering.advance();
            }
        }
    }

    /// The values named below the bar: round ones, and an end with `<` or `>` in place of the tick next to it if there
    /// are values beyond that end.
    fn bar_labels(&self, at_most: u32) -> Vec<(f64, String)> {
        let beyond = |outside: &dyn Fn(f64) -> bool| self.values.iter().any(|value| outside(f64::from(*value)));
        let [below, above] = [beyond(&|v| v < self.scale.from()), beyond(&|v| v > self.scale.to())];
        // A label is about as wide as this part of the bar.
        const LABEL: f64 = 0.15;
        let free = if below { LABEL } else { 0.0 }..=if above { 1.0 - LABEL } else { 1.0 };
        let mut labels: Vec<_> = self
            .scale
            .ticks(at_most.max(2) as usize)
            .into_iter()
            .filter(|value| free.contains(&self.scale.position(*value).clamp(0.0, 1.0)))
            .map(|value| (value, significant(value, 5)))
            .collect();
        if below {
            labels.insert(0, (self.scale.from(), format!("< {}", significant(self.scale.from(), 3))));
        }
        if above {
            labels.push((self.scale.to(), format!("> {}", significant(self.scale.to(), 3))));
        }
        labels
    }
}

/// Where everything stands, in pixels of the picture.
struct Layout {
    size: [u32; 2],
    zoom: u32,
    lettering: Lettering,
    text_height: u32,
    margin: u32,
    left: u32,
    inner_width: u32,
    title: Vec<String>,
    map_at: [u32; 2],
    bar_top: u32,
    bar_height: u32,
    tick: u32,
    key_top: u32,
}

impl Layout {
    fn of(heat_map: &HeatMap) -> Self {
        let [width, height] = heat_map.size;
        let zoom = (LEAST_SIDE / width.max(height)).max(1);
        let [map_width, map_height] = [width * zoom, height * zoom];
        let inner_width = map_width.max(LEAST_SIDE);
        let lettering = Lettering::for_width(inner_width);
        let text_height = lettering.height();
        let margin = text_height * 3 / 4;
        let heading = match heat_map.unit {
            "" => heat_map.title.to_owned(),
            unit => format!("{} ({unit})", heat_map.title),
        };
        let title = wrapped(&heading, (inner_width / lettering.advance()) as usize);
        let map_top = margin + title.len() as u32 * text_height + margin / 2;
        let bar_top = map_top + map_height + margin;
        let (bar_height, tick) = (text_height, text_height / 4);
        let labels_end = bar_top + bar_height + tick + text_height;
        let key = heat_map.values.iter().any(|value| value.is_nan());
        let key_top = labels_end + margin / 2;
        let bottom = if key { key_top + text_height } else { labels_end };
        Self {
            size: [inner_width + 2 * margin, bottom + margin],
            zoom,
            lettering,
            text_height,
            margin,
            left: margin,
            inner_width,
            title,
            map_at: [margin + (inner_width - map_width) / 2, map_top],
            bar_top,
            bar_height,
            tick,
            key_top,
        }
    }
}

/// Breaks a text at spaces into lines of at most `columns` characters; longer words stand alone.
fn wrapped(text: &str, columns: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= columns => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scale::Scaling;

    fn at(picture: &Picture, [x, y]: [u32; 2]) -> [u8; 3] {
        picture.rgb()[(y * picture.size()[0] + x) as usize]
    }

    fn heat_map(values: &[f32], size: [u32; 2], scale: Scale) -> HeatMap<'_> {
        HeatMap { title: "Angle of the exit direction", unit: "\u{b0}", size, values, scale }
    }

    #[test]
    fn map_and_bar_have_the_colours_of_the_scale() {
        let scale = Scale::new(Scaling::Logarithmic, 0.01, 100.0).unwrap();
        let values: Vec<f32> = (0..400).map(|i| 10_f32.powf(i as f32 / 399.0 * 4.0 - 2.0)).collect();
        let map = heat_map(&values, [400, 1], scale);
        let (picture, layout) = (map.draw().unwrap(), Layout::of(&map));
        assert_eq!(layout.inner_width, 400);
        // The values run as the bar below them does, so that each column has one colour, but for rounding.
        for x in 0..400 {
            let of_map = at(&picture, [layout.map_at[0] + x, layout.map_at[1]]);
            let of_bar = at(&picture, [layout.left + x, layout.bar_top]);
            assert!(of_map.iter().zip(of_bar).all(|(a, b)| a.abs_diff(b) <= 2), "{x}: {of_map:?} {of_bar:?}");
        }
        // Published ends and middle of viridis: #440154, #21918c, #fde725.
        assert_eq!(colour(&scale, 0.01), [0x44, 0x01, 0x54]);
        assert!(colour(&scale, 1.0).iter().zip([0x21, 0x91, 0x8c]).all(|(a, b)| a.abs_diff(b) <= 1));
        assert_eq!(colour(&scale, 100.0), [0xfd, 0xe7, 0x25]);
    }

    #[test]
    fn viridis_ascends_in_lightness_and_has_no_grey() {
        let luma = |c: [u8; 3]| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
        let colours: Vec<_> = (0..=100).map(|i| colour_at(f64::from(i) / 100.0)).collect();
        assert!(colours.windows(2).all(|pair| luma(pair[0]) < luma(pair[1])));
        for c in colours {
            let distance: u32 = c.iter().zip(NOT_COMPARED).map(|(a, b)| u32::from(a.abs_diff(b))).sum();
            assert!(distance > 100, "{c:?}");
        }
    }

    #[test]
    fn what_was_not_compared_is_grey_and_small_maps_are_magnified() {
        let map = heat_map(&[f32::NAN, 1.0, 9.0, -4.0], [2, 2], Scale::new(Scaling::Linear, 0.0, 2.0).unwrap());
        let (picture, layout) = (map.draw().unwrap(), Layout::of(&map));
        assert_eq!(layout.zoom, 160);
        let cell = |x: u32, y: u32| at(&picture, [layout.map_at[0] + 80 + 160 * x, layout.map_at[1] + 80 + 160 * y]);
        assert_eq!([cell(0, 0), cell(1, 0)], [NOT_COMPARED, colour_at(0.5)]);
        assert_eq!([cell(0, 1), cell(1, 1)], [colour_at(1.0), colour_at(0.0)]);
        // Values lie beyond both ends, and the bar says so.
        let labels: Vec<_> = map.bar_labels(5).into_iter().map(|(_, text)| text).collect();
        assert_eq!(labels, ["< 0", "0.5", "1", "1.5", "> 2"]);
        // Without anything left out there is no key, and the picture is lower by it.
        let full = heat_map(&[0.0, 1.0, 2.0, 1.0], [2, 2], map.scale);
        assert!(full.draw().unwrap().size()[1] < picture.size()[1]);
    }

    #[test]
    fn titles_are_wrapped_and_drawn() {
        assert_eq!(wrapped("one three five", 9), ["one three", "five"]);
        assert_eq!(wrapped("unbreakable", 4), ["unbreakable"]);
        let values = [0.5; 4];
        let scale = Scale::linear_of(&values);
        let titled = heat_map(&values, [2, 2], scale).draw().unwrap();
        let untitled = HeatMap { title: "", unit: "", ..heat_map(&values, [2, 2], scale) }.draw().unwrap();
        let inked = |picture: &Picture| picture.rgb().iter().filter(|pixel| pixel.iter().all(|c| *c > 150)).count();
        assert!(inked(&titled) > inked(&untitled) + 100);
    }

    #[test]
    fn wrong_maps_are_refused() {
        let scale = Scale::new(Scaling::Linear, 0.0, 1.0).unwrap();
        assert!(matches!(heat_map(&[0.0; 3], [2, 2], scale).draw(), Err(MetricsError::Length { .. })));
        assert!(matches!(heat_map(&[], [0, 2], scale).draw(), Err(MetricsError::Unfit { .. })));
    }
}
