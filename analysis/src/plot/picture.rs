//! Pictures of a state: a drawing to scale with a title and a caption.

use super::drawing::Drawing;
use super::page::PageLayout;
use super::shapes_svg::write_shapes;
use kinetoscope_console::text::xml;
use serde::{Deserialize, Serialize};
use std::num::NonZeroU32;

/// A drawing of a state with a title and a caption.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Picture {
    /// The caption below the title, such as "N = 1000, r = 1 m".
    pub(crate) caption: String,
    /// The size of the container, such as "box of 1 m × 1 m", written below the caption.
    pub(crate) size: String,
    /// The drawing.
    pub(crate) drawing: Drawing,
}

/// Width of the document, px.
const WIDTH: u32 = 620;
/// Height of the title and the captions, px.
const HEADER: u32 = 84;

impl Picture {
    /// The picture as an SVG document; `None` for an empty drawing.
    pub(super) fn svg(&self, title: &str) -> Option<String> {
        let width = const { NonZeroU32::new(WIDTH).expect("not zero") };
        let page = PageLayout::new(std::slice::from_ref(&self.drawing), width)?;
        let caption = match self.drawing.discs.iter().filter(|disc| !page.shows(disc)).count() {
            0 => self.caption.clone(),
            outside => format!("{}; {outside} far outside", self.caption),
        };
        let (middle, height) = (WIDTH / 2, HEADER + page.height);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n"
        );
        for (text, size, y) in [(title, 18, 26), (&caption, 15, 50), (&self.size, 14, 72)] {
            svg += &format!(
                "<text x=\"{middle}\" y=\"{y}\" font-size=\"{size}\" font-family=\"sans-serif\" text-anchor=\"middle\" fill=\"#262626\">{}</text>\n",
                xml(text)
            );
        }
        svg += &format!("<g transform=\"translate(0 {HEADER})\">\n");
        write_shapes(&mut svg, &page, &self.drawing);
        Some(svg + "</g>\n</svg>\n")
    }
}
