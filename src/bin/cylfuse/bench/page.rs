//! The report: one page that needs no other file.

use super::plot::Series;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// A part of the report.
pub struct Section {
    /// The name of the experiment, its anchor.
    pub name: &'static str,
    /// Its heading.
    pub title: String,
    /// What follows it, in HTML.
    pub body: String,
    /// The numbers behind it.
    pub numbers: Vec<Csv>,
    /// What the command prints of it, if anything.
    pub said: Option<String>,
}

/// A file of numbers.
pub struct Csv {
    /// Its name without the extension.
    pub name: &'static str,
    /// Its lines, the first with the names of the columns.
    pub text: String,
}

impl Csv {
    /// A file with the names of its columns.
    pub fn new(name: &'static str, columns: &str) -> Self {
        Self { name, text: format!("{columns}\n") }
    }

    /// Adds a line.
    pub fn push(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }
}

/// Five digits of a number, "" where there is none.
pub fn digits(value: f64) -> String {
    if !value.is_finite() {
        return String::new();
    }
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    format!("{value:.*}", (4 - magnitude).clamp(0, 12) as usize)
}

/// A number for a table: three digits, "–" where there is none.
pub fn shown(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    match value.abs() {
        large if large >= 100.0 => format!("{value:.0}"),
        middle if middle >= 10.0 => format!("{value:.1}"),
        middle if middle >= 0.1 || middle == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// Text as HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A paragraph of text.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// A list of lines of text.
pub fn list(lines: &[String]) -> String {
    let items: String = lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line))).collect();
    format!("<ul>\n{items}</ul>\n")
}

/// A table of text; a cell that begins with "missed" or "reached" is coloured.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = String::from("<div class=\"table\"><table>\n<tr>");
    for cell in head {
        let _ = write!(text, "<th>{}</th>", escaped(cell));
    }
    text.push_str("</tr>\n");
    for row in rows {
        text.push_str("<tr>");
        for cell in row {
            let class = ["missed", "reached"].iter().find(|class| cell.starts_with(*class));
            let class = class.map_or_else(String::new, |class| format!(" class=\"{class}\""));
            let _ = write!(text, "<td{class}>{}</td>", escaped(cell));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</table></div>\n");
    text
}

/// What the colours of plots mean.
pub fn legend(series: &[Series]) -> String {
    let entry = |series: &Series| {
        let [red, green, blue] = series.color;
        format!(
            "<span><i style=\"background:rgb({red},{green},{blue})\"></i>{}</span>",
            escaped(&series.name)
        )
    };
    format!("<p class=\"legend\">{}</p>\n", series.iter().map(entry).collect::<String>())
}

/// Pictures side by side, as many as the page is wide.
pub fn pictures(pictures: &[String]) -> String {
    format!("<div class=\"pictures\">\n{}\n</div>\n", pictures.join("\n"))
}

/// Bytes inside the page.
pub fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// The page.
pub fn page(title: &str, facts: &[(&str, String)], sections: &[Section]) -> String {
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n<dl>\n",
        escaped(title)
    );
    for (name, value) in facts {
        let _ = writeln!(text, "<dt>{}</dt><dd>{}</dd>", escaped(name), escaped(value));
    }
    text.push_str("</dl>\n<nav><ul>\n");
    for section in sections {
        let _ = writeln!(text, "<li><a href=\"#{}\">{}</a></li>", section.name, escaped(&section.title));
    }
    text.push_str("</ul></nav>\n");
    for section in sections {
        let _ = writeln!(
            text,
            "<section id=\"{}\">\n<h2>{}</h2>\n{}",
            section.name,
            escaped(&section.title),
            section.body
        );
        for csv in &section.numbers {
            let link = data("text/csv", csv.text.as_bytes());
            let _ = writeln!(text, "<p><a download=\"{0}.csv\" href=\"{link}\">{0}.csv</a></p>", csv.name);
        }
        text.push_str("</section>\n");
    }
    text.push_str("</body>\n</html>\n");
    text
}

const STYLE: &str = "
:root{color-scheme:light}
body{font:16px/1.5 system-ui,sans-serif;color:#1d2228;background:#fff;max-width:1280px;margin:0 auto;padding:12px}
h1{font-size:1.6em;line-height:1.2}h2{margin-top:2em;border-bottom:2px solid #d5dae0;line-height:1.25}
h3{margin-bottom:.2em}
dl{display:grid;grid-template-columns:max-content 1fr;gap:2px 14px}dt{color:#59636e}dd{margin:0;overflow-wrap:anywhere}
.table{overflow-x:auto;margin:14px 0}table{border-collapse:collapse;font-size:.92em}
th,td{padding:3px 9px;border-bottom:1px solid #d5dae0;text-align:right;white-space:nowrap}
th:first-child,td:first-child{text-align:left;position:sticky;left:0}td:first-child{background:#fff}th{background:#f2f4f7}
td.missed{background:#fde3d8}td.reached{background:#dcefe6}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,340px),1fr));gap:10px}
.pictures svg{width:100%;height:auto;display:block}
.pictures figure{margin:0}figcaption{font-size:.92em;text-align:center}
.legend{display:flex;flex-wrap:wrap;gap:4px 16px}.legend span{white-space:nowrap}
.legend i{display:inline-block;width:14px;height:14px;border-radius:7px;margin-right:6px;vertical-align:-2px}
@media(max-width:700px){th:first-child,td:first-child{white-space:normal;min-width:110px;max-width:140px;\
border-right:1px solid #d5dae0}}
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_say_something() {
        assert_eq!(
            [123.4, 12.34, 1.234, 0.012_34, f64::NAN].map(shown),
            ["123", "12.3", "1.23", "0.012", "–"]
        );
        assert_eq!(
            [123.456_78, 0.001_234_567, 0.0, f64::INFINITY].map(digits),
            ["123.46", "0.0012346", "0.0000", ""]
        );
    }

    #[test]
    fn text_cannot_become_markup() {
        let table = table(&["<b>"], &[vec!["missed & <i>".into()]]);
        assert!(
            table.contains("&lt;b&gt;") && table.contains("<td class=\"missed\">missed &amp; &lt;i&gt;</td>")
        );
    }
}
