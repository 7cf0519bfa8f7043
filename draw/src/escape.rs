//! Text inside HTML and SVG. The templates escape everything that is not marked `safe`.

use askama::filters::Escaper;
use std::fmt::{Result, Write};

/// Escapes by the named character references, for element content and double-quoted attributes.
#[derive(Clone, Copy)]
pub struct Named;

impl Escaper for Named {
    fn write_escaped_str<W: Write>(&self, mut destination: W, text: &str) -> Result {
        for character in text.chars() {
            match character {
                '&' => destination.write_str("&amp;")?,
                '<' => destination.write_str("&lt;")?,
                '>' => destination.write_str("&gt;")?,
                '"' => destination.write_str("&quot;")?,
                other => destination.write_char(other)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let mut escaped = String::new();
        Named.write_escaped_str(&mut escaped, r#"a < b & "c" > d"#).unwrap();
        assert_eq!(escaped, "a &lt; b &amp; &quot;c&quot; &gt; d");
    }
}
