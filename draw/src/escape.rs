//! Escapes text for HTML and SVG. The templates escape everything that is not marked `safe`.

use askama::filters::Escaper;
use std::fmt::{self, Display, Formatter, Write};

/// A text that is escaped when displayed, for element content or a quoted attribute.
#[derive(Clone, Copy, Debug)]
pub struct Text<'a>(pub &'a str);

impl Display for Text<'_> {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        Named.write_escaped_str(formatter, self.0)
    }
}

/// Escapes with named character references, for element content and quoted attributes.
#[derive(Clone, Copy)]
pub struct Named;

impl Escaper for Named {
    fn write_escaped_str<W: Write>(&self, mut destination: W, text: &str) -> fmt::Result {
        for character in text.chars() {
            match character {
                '&' => destination.write_str("&amp;")?,
                '<' => destination.write_str("&lt;")?,
                '>' => destination.write_str("&gt;")?,
                '"' => destination.write_str("&quot;")?,
                '\'' => destination.write_str("&#39;")?,
                // XML and HTML allow no control characters except these three: replace all others.
                other if other.is_control() && !matches!(other, '\n' | '\r' | '\t') => {
                    destination.write_char(char::REPLACEMENT_CHARACTER)?;
                }
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
        assert_eq!(
            Text("a < b & \"c\" > 'd'\n\u{1}").to_string(),
            "a &lt; b &amp; &quot;c&quot; &gt; &#39;d&#39;\n\u{fffd}"
        );
    }
}
