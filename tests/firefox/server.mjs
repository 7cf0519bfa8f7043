// Tabs of `plcfmu tool` in Firefox, by WebDriver BiDi: as many as it is told, in each of the first two of which a loop is started. Prints a
// line when that is done, closes the second for a line of standard input, and ends with it.
//
//     node server.mjs FIREFOX ADDRESS TABS REQUEST

import { createInterface } from "node:readline";
import puppeteer from "puppeteer-core";

const [firefox, address, tabs, request] = process.argv.slice(2);
const browser = await puppeteer.launch({ browser: "firefox", executablePath: firefox, headless: true });
try {
  const pages = [];
  for (let number = 0; number < Number(tabs); number++) {
    const page = await browser.newPage();
    await page.goto(number === 0 ? address : pages[0].url());
    await page.waitForSelector("#new-block option");
    pages.push(page);
  }
  for (const page of pages.slice(0, 2)) {
    await page.evaluate(async (setup) => {
      const { ask } = await globalThis.moduleOf("tool/engine.js");
      await ask(setup);
    }, JSON.parse(request));
  }
  console.log("started");
  for await (const _ of createInterface({ input: process.stdin })) await pages[1].close();
} finally {
  await browser.close();
}
