//! The page's frame: style sheet, escaping, tables. Nothing on the page comes from elsewhere.

/// Text for HTML.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// A table; the cells are HTML. Columns after the first `left` are set to the right.
#[must_use]
pub fn table(head: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let class = |i: usize| if i < left { "" } else { " class=\"n\"" };
    let mut out = String::from("<div class=\"scroll\"><table><thead><tr>");
    for (i, cell) in head.iter().enumerate() {
        out.push_str(&format!("<th{}>{}</th>", class(i), escape(cell)));
    }
    out.push_str("</tr></thead><tbody>\n");
    for row in rows {
        out.push_str("<tr>");
        for (i, cell) in row.iter().enumerate() {
            out.push_str(&format!("<td{}>{cell}</td>", class(i)));
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div>\n");
    out
}

const STYLE: &str = "
:root{color-scheme:light dark;--bg:#f6f7f9;--card:#ffffff;--ink:#1d2430;--soft:#5c6675;--line:#d8dde5;--good:#187a3f;--bad:#b3261e;--accent:#1f6fb5}
@media(prefers-color-scheme:dark){:root{--bg:#14171c;--card:#1c2028;--ink:#e4e8ee;--soft:#9aa4b2;--line:#343b47;--good:#5cc98a;--bad:#ff8a80;--accent:#7db8ec}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--ink);font:15px/1.55 system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif}
main{max-width:1180px;margin:0 auto;padding:28px 22px 60px}
h1{font-size:28px;line-height:1.2;margin:0 0 4px}
h2{font-size:20px;margin:44px 0 8px;padding-top:12px;border-top:1px solid var(--line)}
h3{font-size:15px;margin:22px 0 4px}
p{margin:6px 0 12px;max-width:78ch}
.soft,figcaption,.legend,.bar{color:var(--soft)}
nav{margin:14px 0 0;font-size:14px;line-height:1.9}
nav a{color:var(--accent);text-decoration:none;margin-right:16px;white-space:nowrap}
nav a:hover{text-decoration:underline}
.grid{display:flex;flex-wrap:wrap;gap:14px;align-items:flex-start}
figure{margin:0;background:var(--card);border:1px solid var(--line);border-radius:8px;padding:10px 12px;max-width:100%}
figcaption{font-size:13px;margin-bottom:4px}
.chart svg{display:block;max-width:100%;height:auto}
.legend{font-size:12.5px;display:flex;flex-wrap:wrap;gap:2px 14px;margin-top:2px;max-width:520px}
.legend span{white-space:nowrap}
.key{display:inline-block;width:20px;border-top:2.5px solid;vertical-align:middle;margin-right:5px}
.key.dashed{border-top-style:dashed}
.key.dots{width:0;border-top:0;border-left:7px solid;height:7px;border-radius:4px}
.bar{display:flex;gap:8px;align-items:center;font-size:12.5px;margin:6px 0 10px}
.bar i{display:inline-block;width:220px;height:12px;border-radius:3px}
.scroll{overflow-x:auto;margin:8px 0 14px}
table{border-collapse:collapse;font-size:13.5px;background:var(--card);border:1px solid var(--line)}
th,td{padding:5px 8px;text-align:left;border-bottom:1px solid var(--line);vertical-align:top}
th{font-weight:600;color:var(--soft);border-bottom:2px solid var(--line)}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
td.n{white-space:nowrap}
tr:last-child td{border-bottom:0}
.good{color:var(--good);font-weight:600}
.bad{color:var(--bad);font-weight:600}
.skies{width:100%}
.skies h3{margin:18px 0 6px}
.triple{padding:8px;background:#2a2e35;border-color:#2a2e35}
.triple figcaption{color:#c9ced6}
.triple img{display:inline-block;width:168px;max-width:31%;height:auto;vertical-align:top;border-radius:50%;margin:1px}
.triple figcaption{margin:0 0 4px}
code{font-size:13px;overflow-wrap:anywhere}
";

/// A section of the page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Anchor.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// HTML.
    pub body: String,
}

/// The whole page.
#[must_use]
pub fn page(title: &str, lead: &str, sections: &[Section]) -> String {
    let links: String = sections
        .iter()
        .map(|s| format!("<a href=\"#{}\">{}</a>\n", s.id, escape(s.title)))
        .collect();
    let bodies: String = sections
        .iter()
        .map(|s| {
            format!(
                "<section id=\"{}\"><h2>{}</h2>\n{}</section>\n",
                s.id,
                escape(s.title),
                s.body
            )
        })
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style></head>\n<body><main>\n\
         <h1>{title}</h1>\n<p class=\"soft\">{lead}</p>\n<nav>{links}</nav>\n{bodies}\
         </main></body></html>\n",
        title = escape(title),
    )
}
