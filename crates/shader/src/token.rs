//! WGSL text as tokens. Texts are taken apart and put together by tokens, never by patterns, so
//! that no comment, member or longer name is ever mistaken for the name that is meant.

use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A name or keyword.
    Word,
    Number,
    /// Any other sign; signs of several characters come as several tokens.
    Sign(u8),
}

#[derive(Clone, Debug)]
pub struct Token {
    pub kind: Kind,
    pub span: Range<usize>,
}

impl Token {
    pub fn is(&self, sign: u8) -> bool {
        self.kind == Kind::Sign(sign)
    }

    pub fn text<'t>(&self, source: &'t str) -> &'t str {
        &source[self.span.clone()]
    }
}

/// The tokens of `source`, without white space and comments (block comments nest in WGSL). Never
/// fails: what is not WGSL comes as signs, and the compiler says what is wrong with them.
pub fn tokens(source: &str) -> Vec<Token> {
    let bytes = source.as_bytes();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = &source[at..];
        let (kind, len) = if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
            continue;
        } else if rest.starts_with("/*") {
            at += block_comment(rest.as_bytes());
            continue;
        } else if byte.is_ascii_whitespace() {
            at += 1;
            continue;
        } else if byte.is_ascii_digit()
            || (byte == b'.' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit))
        {
            (Kind::Number, number(rest.as_bytes()))
        } else if let len @ 1.. = word(rest) {
            (Kind::Word, len)
        } else {
            let len = rest.chars().next().map_or(1, char::len_utf8);
            (Kind::Sign(byte), len)
        };
        tokens.push(Token {
            kind,
            span: at..at + len,
        });
        at += len;
    }
    tokens
}

fn word(rest: &str) -> usize {
    rest.char_indices()
        .find(|&(i, c)| !(c == '_' || c.is_alphabetic() || (i > 0 && c.is_alphanumeric())))
        .map_or(rest.len(), |(i, _)| i)
}

fn number(rest: &[u8]) -> usize {
    let hexadecimal = rest.len() > 1 && rest[0] == b'0' && rest[1] | 32 == b'x';
    let mut len = 1;
    while let Some(&byte) = rest.get(len) {
        let exponent = if hexadecimal { b'p' } else { b'e' };
        let signed = matches!(byte, b'+' | b'-') && rest[len - 1] | 32 == exponent;
        if !(byte.is_ascii_alphanumeric() || byte == b'.' || signed) {
            break;
        }
        len += 1;
    }
    len
}

fn block_comment(rest: &[u8]) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        match rest.get(at..at + 2) {
            Some(b"/*") => {
                depth += 1;
                at += 2;
            }
            Some(b"*/") => {
                depth -= 1;
                at += 2;
                if depth == 0 {
                    return at;
                }
            }
            _ => at += 1,
        }
    }
    rest.len()
}

/// What stands at the top level of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeclarationKind {
    Function,
    Struct,
    Constant,
    Alias,
    /// `var<private>`: what a module remembers along a ray.
    Private,
    /// A variable of another address space, or an override.
    Resource,
    /// `enable`, `requires`, `diagnostic`.
    Directive,
}

/// A declaration at the top level.
#[derive(Clone, Debug)]
pub struct Declaration {
    pub kind: DeclarationKind,
    pub name: String,
    /// Where the name stands.
    pub span: Range<usize>,
    /// Which tokens belong to it, from its keyword to its end.
    pub tokens: Range<usize>,
}

/// The declarations of `source`, as far as they can be told without understanding them.
pub fn declarations(source: &str, tokens: &[Token]) -> Vec<Declaration> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let keyword = tokens[at].text(source);
        let mut kind = match keyword {
            "fn" => DeclarationKind::Function,
            "struct" => DeclarationKind::Struct,
            "const" => DeclarationKind::Constant,
            "alias" => DeclarationKind::Alias,
            "var" | "override" => DeclarationKind::Resource,
            "enable" | "requires" | "diagnostic" => DeclarationKind::Directive,
            _ => {
                at = if tokens[at].is(b'{') {
                    closing(tokens, at, b'{', b'}')
                } else {
                    at
                } + 1;
                continue;
            }
        };
        let mut name = at + 1;
        if keyword == "var" && tokens.get(name).is_some_and(|t| t.is(b'<')) {
            let end = closing(tokens, name, b'<', b'>');
            if tokens
                .get(name + 1)
                .is_some_and(|t| t.text(source) == "private")
            {
                kind = DeclarationKind::Private;
            }
            name = end + 1;
        }
        let end = end_of_declaration(tokens, at, kind);
        if let Some(token) = tokens.get(name) {
            found.push(Declaration {
                kind,
                name: token.text(source).to_owned(),
                span: token.span.clone(),
                tokens: at..end,
            });
        }
        at = end.max(at + 1);
    }
    found
}

fn end_of_declaration(tokens: &[Token], from: usize, kind: DeclarationKind) -> usize {
    let with_body = matches!(kind, DeclarationKind::Function | DeclarationKind::Struct);
    let stop = if with_body { b'{' } else { b';' };
    match tokens[from..].iter().position(|t| t.is(stop)) {
        Some(i) if with_body => closing(tokens, from + i, b'{', b'}') + 1,
        Some(i) => from + i + 1,
        None => tokens.len(),
    }
}

/// The index of the sign that closes the one at `open`, or of the last token.
pub fn closing(tokens: &[Token], open: usize, opens: u8, closes: u8) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        if token.is(opens) {
            depth += 1;
        } else if token.is(closes) {
            depth -= 1;
            if depth == 0 {
                return i;
            }
        }
    }
    tokens.len().saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(source: &str) -> Vec<&str> {
        tokens(source).iter().map(|t| t.text(source)).collect()
    }

    #[test]
    fn comments_numbers_and_names_are_told_apart() {
        assert_eq!(
            words("let a=1.5e-3+b.x;// c\n/* d /* e */ f */0x1p+3u .5f ünter_1"),
            [
                "let", "a", "=", "1.5e-3", "+", "b", ".", "x", ";", "0x1p+3u", ".5f", "ünter_1"
            ]
        );
        assert_eq!(words("/* open"), Vec::<&str>::new());
        assert_eq!(words("a€b"), ["a", "€", "b"]);
    }

    #[test]
    fn declarations_are_found_at_the_top_only() {
        let source = "const A = 1; struct S { fn_: f32 } var<private> p: f32 = 2.0;
            fn f(x: f32) -> f32 { const inner = 1.0; return x; }
            @group(0) @binding(0) var<uniform> u: S; var t: texture_3d<f32>; alias V = vec3f;";
        let found: Vec<_> = declarations(source, &tokens(source))
            .into_iter()
            .map(|d| (d.kind, d.name))
            .collect();
        let expected = [
            (DeclarationKind::Constant, "A"),
            (DeclarationKind::Struct, "S"),
            (DeclarationKind::Private, "p"),
            (DeclarationKind::Function, "f"),
            (DeclarationKind::Resource, "u"),
            (DeclarationKind::Resource, "t"),
            (DeclarationKind::Alias, "V"),
        ];
        assert_eq!(found, expected.map(|(k, n)| (k, n.to_owned())));
    }
}
