//! What QGIS draws the tables with: styles in the table `layer_styles`, where QGIS itself keeps them.

use std::fmt::Write;

use crate::sink::colour::colour;

/// A fill of one colour with a thin outline, as the QML of a symbol.
fn fill(name: &str, [r, g, b]: [f64; 3]) -> String {
    let byte = |share: f64| (share * 255.0).round() as u8;
    let (r, g, b) = (byte(r), byte(g), byte(b));
    format!(
        "<symbol type=\"fill\" name=\"{name}\" alpha=\"1\"><layer class=\"SimpleFill\"><Option type=\"Map\">\
         <Option name=\"color\" type=\"QString\" value=\"{r},{g},{b},255\"/>\
         <Option name=\"outline_color\" type=\"QString\" value=\"60,60,60,255\"/>\
         <Option name=\"outline_width\" type=\"QString\" value=\"0.1\"/>\
         <Option name=\"style\" type=\"QString\" value=\"solid\"/></Option></layer></symbol>"
    )
}

fn qml(renderer: &str) -> String {
    format!(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\
         <qgis version=\"3.22\" styleCategories=\"Symbology\">{renderer}</qgis>"
    )
}

/// Footprints in one colour.
pub(super) fn footprints() -> String {
    let symbol = fill("0", [0.83, 0.69, 0.58]);
    qml(&format!("<renderer-v2 type=\"singleSymbol\"><symbols>{symbol}</symbols></renderer-v2>"))
}

/// Faces by their class, those that are seen from above on top.
pub(super) fn faces(classes: impl Iterator<Item = impl AsRef<str>>) -> String {
    let (mut categories, mut symbols) = (String::new(), String::new());
    for (i, class) in classes.enumerate() {
        let class = class.as_ref();
        let text = escaped(class);
        let _ = write!(
            categories,
            "<category value=\"{text}\" label=\"{text}\" symbol=\"{i}\" render=\"true\" type=\"string\"/>"
        );
        symbols += &fill(&i.to_string(), colour(class));
    }
    qml(&format!(
        "<renderer-v2 type=\"categorizedSymbol\" attr=\"surface_type\" enableorderby=\"1\"><categories>{categories}</categories>\
         <symbols>{symbols}</symbols><orderby><orderByClause asc=\"1\" nullsFirst=\"1\">\
         CASE WHEN surface_type = 'RoofSurface' THEN 1 ELSE 0 END</orderByClause></orderby></renderer-v2>"
    ))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
