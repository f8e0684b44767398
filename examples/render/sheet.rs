//! Many pictures on one, each with a caption.

use tiny_skia::{Pixmap, PixmapPaint, Transform};

use crate::text;

/// A picture with the lines of text below it.
pub struct Tile {
    /// The pictures, side by side.
    pub pictures: Vec<Pixmap>,
    /// Lines of text.
    pub caption: Vec<String>,
}

/// Lays the tiles out in rows, about as wide as high. `None` without tiles.
pub fn contact_sheet(tiles: &[Tile]) -> Option<Pixmap> {
    let gap = 6;
    let width = tiles.iter().map(|t| t.pictures.iter().map(|p| p.width() as usize).sum::<usize>()).max()? + gap;
    let picture_height = tiles.iter().flat_map(|t| &t.pictures).map(|p| p.height() as usize).max()?;
    let lines = tiles.iter().map(|t| t.caption.len()).max()?;
    let dot = if width >= 500 { 2 } else { 1 };
    let height = picture_height + lines * text::line_height(dot) + 2 * gap;
    let columns = ((tiles.len() * height) as f64 / width as f64).sqrt().ceil().max(1.0) as usize;
    let columns = columns.min(tiles.len());
    let rows = tiles.len().div_ceil(columns);
    let mut sheet = Pixmap::new((columns * width + gap) as u32, (rows * height + gap) as u32)?;
    sheet.fill(tiny_skia::Color::WHITE);
    for (index, tile) in tiles.iter().enumerate() {
        let (left, top) = (gap + index % columns * width, gap + index / columns * height);
        let mut x = left as i32;
        for picture in &tile.pictures {
            sheet.draw_pixmap(x, top as i32, picture.as_ref(), &PixmapPaint::default(), Transform::identity(), None);
            x += picture.width() as i32;
        }
        for (line, words) in tile.caption.iter().enumerate() {
            let y = top + picture_height + gap / 2 + line * text::line_height(dot);
            let letters: String = words.chars().take(text::fitting(width - gap, dot)).collect();
            text::write(&mut sheet, &letters, [left, y], dot, [30, 30, 30]);
        }
    }
    Some(sheet)
}
