//! Random ladder networks, written as a document and as SCL, have equal bits after each call.

use super::{Random, compare, pair};

/// The number of blocks compared, and of networks in each.
const BLOCKS: u64 = 40;
const NETWORKS: u64 = 10;

/// The output of both writers.
#[derive(Default)]
struct Written {
    document: String,
    source: String,
    /// The number of bits for edges, temporaries and instances.
    bits: u32,
    flows: u32,
    instances: u32,
}

const VARIABLES: [&str; 9] = ["a", "b", "c", "s", "r", "y", "z", "m", "o"];
const WRITTEN: [&str; 4] = ["y", "z", "m", "o"];
const NUMBERS: [&str; 4] = ["i", "j", "n", "k"];

fn of<'a>(random: &mut Random, names: &[&'a str]) -> &'a str {
    names[random.below(names.len() as u64) as usize]
}

impl Written {
    fn bit(&mut self) -> String {
        self.bits += 1;
        format!("e{}", self.bits)
    }

    fn flow(&mut self) -> String {
        self.flows += 1;
        format!("f{}", self.flows)
    }

    /// Adds an element: as written in the document, and the statements that compute its flow.
    fn element(&mut self, document: &str, source: &str) {
        self.document += &format!(" {document}");
        self.source += &format!("{source}\n");
    }

    /// Adds an element that passes or blocks the flow.
    fn pass(&mut self, random: &mut Random, f: &str) {
        let (v, i, j) = (of(random, &VARIABLES), of(random, &NUMBERS), of(random, &NUMBERS));
        let bit = self.bit();
        match random.below(9) {
            0 | 1 => self.element(&format!("Contact( #{v} )"), &format!("#{f} := #{f} AND #{v};")),
            2 => self.element(&format!("I_Contact( #{v} )"), &format!("#{f} := #{f} AND NOT #{v};")),
            3 => self.element(
                &format!("P_Contact( operand := #{v}, bit := #{bit} )"),
                &format!("#{f} := #{f} AND #{v} AND NOT #{bit}; #{bit} := #{v};"),
            ),
            4 => self.element(
                &format!("N_Contact( #{v}, #{bit} )"),
                &format!("#{f} := #{f} AND NOT #{v} AND #{bit}; #{bit} := #{v};"),
            ),
            5 => self.element(
                &format!("P_Trig( #{bit} )"),
                &format!("#h := #{f}; #{f} := #{f} AND NOT #{bit}; #{bit} := #h;"),
            ),
            6 => self.element("Not()", &format!("#{f} := NOT #{f};")),
            _ => {
                let (name, operator) = [("GT", ">"), ("Le", "<="), ("NE", "<>")][random.below(3) as usize];
                self.element(
                    &format!("{{ S7_Templates := \"SrcType := Int\" }} {name}_Contact( in1 := #{i}, in2 := #{j} )"),
                    &format!("#{f} := #{f} AND #{i} {operator} #{j};"),
                );
            }
        }
    }

    /// Adds an element that writes to a variable.
    fn act(&mut self, random: &mut Random, f: &str) {
        let v = of(random, &WRITTEN);
        let (bit, n) = (self.bit(), of(random, &["n", "k"]));
        self.instances += 1;
        let instance = self.instances;
        match random.below(10) {
            0 | 1 => self.element(&format!("Coil( #{v} )"), &format!("#{v} := #{f};")),
            2 => self.element(&format!("I_Coil( #{v} )"), &format!("#{v} := NOT #{f};")),
            3 => self.element(&format!("S_Coil( #{v} )"), &format!("IF #{f} THEN #{v} := TRUE; END_IF;")),
            4 => self.element(&format!("R_Coil( #{v} )"), &format!("IF #{f} THEN #{v} := FALSE; END_IF;")),
            5 => self.element(
                &format!("P_Coil( operand => #{v}, bit := #{bit} )"),
                &format!("#{v} := #{f} AND NOT #{bit}; #{bit} := #{f};"),
            ),
            6 => self.element(
                &format!("#{v}.S_SR( r1 := #r )"),
                &format!("#{v} := (#{f} OR #{v}) AND NOT #r; #{f} := #{v};"),
            ),
            7 => self.element(
                &format!("{{ S7_Templates := \"SrcType := Int\" }} Add( in1 := #{n}, in2 := #i, out => #{n} )"),
                &format!("IF #{f} THEN #{n} := #{n} + #i; END_IF;"),
            ),
            8 => self.element(
                &format!("{{ S7_Templates := \"time_type := Time\" }} #t{instance}.TON( pt := T#200ms, et => #et )"),
                &format!("#t{instance}.TON(IN := #{f}, PT := T#200ms, ET => #et); #{f} := #t{instance}.Q;"),
            ),
            _ => self.element(
                &format!("{{ S7_Templates := \"value_type := Int\" }} #c{instance}.CTU( r := #r, pv := 2, cv => #cv )"),
                &format!("#c{instance}.CTU(CU := #{f}, R := #r, PV := 2, CV => #cv); #{f} := #c{instance}.Q;"),
            ),
        }
    }

    /// Adds a main rung with two positions, branches to them, and a rung that begins at the second. In a document the
    /// branches follow the main rung, whose coils need them; in SCL they come first.
    fn network(&mut self, random: &mut Random) {
        self.document += "    { S7_Language := \"LAD\" }\n    NETWORK\n";
        let (first, second) = (self.flow(), self.flow());
        let (mut main, mut branches) = (String::new(), String::new());
        self.source += &format!("#{first} := TRUE;\n");
        let mut outer = std::mem::take(&mut self.document);
        (0..1 + random.below(2)).for_each(|_| self.pass(random, &first));
        main += &format!("        RUNG wire#powerrail{} wire#w1", std::mem::take(&mut self.document));
        for _ in 0..random.below(3) {
            let branch = self.flow();
            self.source += &format!("#{branch} := TRUE;\n");
            (0..1 + random.below(2)).for_each(|_| self.pass(random, &branch));
            let steps = std::mem::take(&mut self.document);
            branches += &format!("        RUNG wire#powerrail{steps} END_RUNG wire#w1\n");
            self.source += &format!("#{first} := #{first} OR #{branch};\n");
        }
        self.source += &format!("#{second} := #{first};\n");
        (0..1 + random.below(2)).for_each(|_| self.pass(random, &second));
        main += &format!("{} wire#w2", std::mem::take(&mut self.document));
        for _ in 0..random.below(3) {
            let branch = self.flow();
            let (from, value) =
                if random.below(2) == 0 { ("w1", format!("#{first}")) } else { ("powerrail", "TRUE".to_string()) };
            self.source += &format!("#{branch} := {value};\n");
            (0..1 + random.below(2)).for_each(|_| self.pass(random, &branch));
            let steps = std::mem::take(&mut self.document);
            branches += &format!("        RUNG wire#{from}{steps} END_RUNG wire#w2\n");
            self.source += &format!("#{second} := #{second} OR #{branch};\n");
        }
        let (out, side) = (self.flow(), self.flow());
        self.source += &format!("#{out} := #{second};\n");
        (0..1 + random.below(3)).for_each(|_| self.act(random, &out));
        main += &std::mem::take(&mut self.document);
        self.source += &format!("#{side} := #{second};\n");
        self.pass(random, &side);
        self.act(random, &side);
        let steps = std::mem::take(&mut self.document);
        outer += &format!("{main} END_RUNG\n{branches}        RUNG wire#w2{steps} END_RUNG\n    END_NETWORK\n");
        self.document = outer;
    }
}

#[test]
fn random_networks_are_equal_to_their_statements() {
    for block in 0..BLOCKS {
        let mut random = Random(block);
        let mut written = Written::default();
        (0..NETWORKS).for_each(|_| written.network(&mut random));
        let bits: String = (1..=written.bits).map(|bit| format!("e{bit} : Bool; ")).collect();
        let instances: String =
            (1..=written.instances).map(|number| format!("t{number} : TON_TIME; c{number} : CTU_INT; ")).collect();
        let flows: String = (1..=written.flows).map(|flow| format!("f{flow} : Bool; ")).collect();
        let sections = format!("VAR m : Bool; o : Bool; {bits}{instances} END_VAR VAR_TEMP h : Bool; {flows} END_VAR");
        let (document, source) = pair(&sections, &written.document, &written.source);
        compare(&document, &source, "", 30, block);
    }
}
