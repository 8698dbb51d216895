"""Reports as one sees and uses them."""

import io

from PIL import Image

from browser import DESKTOP, INTERACTIVE, PHONE, Browser, center, differ

# WCAG 2.2, relative luminance and contrast, of each text with what is painted behind it.
CONTRASTS = """() => {
  const channel = (value) => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  const luminance = ([r, g, b]) => 0.2126 * channel(r / 255) + 0.7152 * channel(g / 255) + 0.0722 * channel(b / 255);
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const parse = (color) => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = color;
    canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data];
  };
  const behind = (element) => {
    for (let each = element; each; each = each.parentElement) {
      const color = parse(getComputedStyle(each).backgroundColor);
      if (color[3] === 255) return color;
    }
    return [255, 255, 255, 255];
  };
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim();
    const element = walker.currentNode.parentElement;
    if (!text || ["SCRIPT", "STYLE", "OPTION"].includes(element.tagName) || !element.checkVisibility({ visibilityProperty: true })) continue;
    const style = getComputedStyle(element);
    const color = parse(element.ownerSVGElement ? style.fill : style.color);
    const [a, b] = [luminance(color), luminance(behind(element))].sort((x, y) => y - x);
    found.push({ text: text.slice(0, 40), contrast: (a + 0.05) / (b + 0.05) });
  }
  return found;
}"""


class Whole(Browser):
    """The page as a whole."""

    def test_screenshots_of_all_pages(self):
        for name in ("page", "compare"):
            for size, scheme, kind in [(DESKTOP, "light", "light"), (DESKTOP, "dark", "dark"), (PHONE, "light", "phone")]:
                page = self.open(f"{name}.html", size, scheme)
                self.shoot(page, f"{name}-{kind}", full_page=True)

    def test_the_policy_keeps_the_page_from_the_network(self):
        page = self.open()
        for attempt in ("fetch('https://sundog.invalid/x')", "fetch('data:,x')", "import('https://sundog.invalid/x.js')"):
            outcome = page.evaluate(f"() => {attempt}.then(() => 'fetched', () => 'refused')")
            self.assertEqual(outcome, "refused", attempt)
        self.assertTrue(any("Content Security Policy" in complaint for complaint in self.complaints))
        self.complaints = [each for each in self.complaints if "Content Security Policy" not in each and "sundog.invalid" not in each]

    def test_nothing_scrolls_sideways_on_a_telephone(self):
        for name in ("page.html", "compare.html"):
            page = self.open(name, PHONE)
            page.locator("summary").first.click()
            self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), PHONE[0], name)

    def test_text_can_be_read_in_light_and_dark(self):
        for name in ("page.html", "compare.html"):
            for scheme in ("light", "dark"):
                page = self.open(name, scheme=scheme)
                page.locator("summary").first.click()
                page.locator(".plot .stage").first.hover()
                texts = page.evaluate(CONTRASTS)
                self.assertGreater(len(texts), 50)
                poor = [each for each in texts if each["contrast"] < 4.5]
                self.assertEqual(poor, [], scheme)

    def test_the_switch_changes_the_colours_and_is_kept(self):
        page = self.open(scheme="light")
        before = self.shoot(page, "switch-light")
        switch = page.locator("#theme")
        self.assertEqual(switch.get_attribute("aria-label"), "Dark colours")
        switch.click()
        after = self.shoot(page, "switch-dark")
        self.assertGreater(min(before.getpixel((5, 5))), 240)
        self.assertLess(max(after.getpixel((5, 5))), 40)
        poor = [each for each in page.evaluate(CONTRASTS) if each["contrast"] < 4.5]
        self.assertEqual(poor, [])
        page.reload()
        self.assertEqual(switch.get_attribute("aria-label"), "Light colours")
        switch.click()
        # (But for the ring around the switch, which has the focus.)
        self.assertLess(differ(before, self.shoot(page, "switch-light-again")), 2000)

    def test_tab_reaches_everything_and_shows_where_it_is(self):
        for name in ("page.html", "compare.html"):
            page = self.open(name)
            wanted = page.evaluate(f"""() => [...document.querySelectorAll("{INTERACTIVE}")]
                .filter((each) => each.tabIndex >= 0 && each.checkVisibility())
                .map((each, index) => each.dataset.order = String(index)).length""")
            self.assertGreater(wanted, 12)
            reached = []
            for _ in range(wanted):
                page.keyboard.press("Tab")
                active = page.locator("[data-order]:focus")
                reached.append(active.get_attribute("data-order"))
                style = active.evaluate("(each) => { const s = getComputedStyle(each); return [s.outlineStyle, parseFloat(s.outlineWidth)]; }")
                self.assertEqual(style[0], "solid")
                self.assertGreaterEqual(style[1], 2)
            self.assertEqual(reached, [str(index) for index in range(wanted)])

    def test_focus_is_seen(self):
        page = self.open()
        for selector in ("nav a", "#theme", ".save a", ".sortable button", ".slider input", ".slider select", ".map .stage", "summary"):
            element = page.locator(selector).first
            element.scroll_into_view_if_needed()
            page.evaluate("document.activeElement.blur()")
            box = element.bounding_box()
            clip = {"x": max(0, box["x"] - 8), "y": max(0, box["y"] - 8), "width": box["width"] + 16, "height": box["height"] + 16}
            without = Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")
            # A key before it makes it a focus by keyboard.
            page.keyboard.press("Shift")
            element.focus()
            with_focus = Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")
            # The ring is three pixels wide all around.
            self.assertGreater(differ(without, with_focus), 2 * (box["width"] + box["height"]), selector)

    def test_everything_has_a_name(self):
        for name in ("page.html", "compare.html"):
            page = self.open(name)
            nodes = page.context.new_cdp_session(page).send("Accessibility.getFullAXTree")["nodes"]
            focusable = [node for node in nodes if any(
                each["name"] == "focusable" and each["value"]["value"] for each in node.get("properties", []))]
            self.assertGreater(len(focusable), 12)
            nameless = [node["role"]["value"] for node in focusable
                        if not node.get("name", {}).get("value") and node["role"]["value"] != "RootWebArea"]
            # (A part that can be scrolled is focusable by itself.)
            self.assertEqual([role for role in nameless if role not in ("generic", "none")], [])

    def test_paper_shows_all_pictures_and_no_controls(self):
        page = self.open()
        page.emulate_media(media="print")
        self.shoot(page, "page-print", full_page=True)
        for selector in ("#theme", "nav", ".choices", ".slider input", ".save", ".slider .bar"):
            self.assertFalse(page.locator(selector).first.is_visible(), selector)
        pictures = page.locator(".slider img")
        self.assertEqual(pictures.count(), 3)
        tops = [pictures.nth(index).bounding_box()["y"] for index in range(3)]
        self.assertEqual(tops, sorted(set(tops)))
        data = page.pdf()
        self.assertGreater(len(data), 10_000)


class Plots(Browser):
    """Curves."""

    def test_the_pointer_reads_the_nearest_point(self):
        for size, holder, kind in [(DESKTOP, ".wide", "desktop"), (PHONE, ".narrow", "phone")]:
            page = self.open(size=size)
            plot = page.locator(".plot").first
            plot.scroll_into_view_if_needed()
            # The circles are 1, 2, 4 … samples; a spread's middle is a circle, too, of another opacity.
            point = plot.locator(f"{holder} circle[fill='#0072B2'][opacity='1']").nth(6)
            x, y = center(point)
            page.mouse.move(x + 3, y - 4)
            tip = plot.locator(".tip")
            text = tip.inner_text()
            self.shoot(page, f"hover-{kind}")
            # 64 samples at 20 ms; 40 % / 8, 0.7 and 1.7 times that, and the fitted line at the same time.
            self.assertIn("64 samples", text)
            rows = [row.inner_text().split("\t") for row in tip.locator("tbody tr").all()]
            rows = [[cell.replace("\u00a0", " ").strip() for cell in row] for row in rows]
            self.assertEqual(rows, [
                ["uniform", "1.28 s", "5 % (4.5 to 5.5)"],
                ["adaptive", "1.28 s", "3.5 % (3.15 to 3.85)"],
                ["Cycles", "1.28 s", "8.5 % (7.65 to 9.35)"],
                ["fit, slope −0.500", "", "≈ 5 %"],
            ])
            self.assertEqual(plot.locator(".chosen").inner_text().split("\t")[0].strip(), "uniform")
            ring = center(plot.locator(".ring"))
            self.assertLess(abs(ring[0] - x) + abs(ring[1] - y), 2)
            box, stage = tip.bounding_box(), plot.locator(".stage").bounding_box()
            self.assertGreaterEqual(box["x"], stage["x"] - 1)
            self.assertLessEqual(box["x"] + box["width"], stage["x"] + stage["width"] + 1)
            page.mouse.move(2, 2)
            self.assertFalse(tip.is_visible())

    def test_keys_go_along_the_curves(self):
        page = self.open()
        stage, spoken = page.locator(".plot .stage").first, page.locator(".plot .spoken").first

        def press(*keys):
            for key in keys:
                page.keyboard.press(key)
            return spoken.inner_text().replace("\u00a0", " ")

        page.keyboard.press("Shift")
        stage.focus()
        self.assertEqual(press(), "uniform, 1 samples: time 0.02 s, error 40 %, 36 to 44")
        self.assertIn("2 samples: time 0.04 s, error 28.28 %", press("ArrowRight"))
        self.assertIn("adaptive, 2 samples: time 0.04 s, error 19.8 %", press("ArrowDown"))
        self.assertIn("adaptive, 1024 samples: time 20.48 s, error 0.875 %", press("End", "ArrowRight"))
        # Cycles ends earlier: its point at 10 s is not a number and left out.
        self.assertIn("Cycles, 256 samples: time 5.12 s, error 4.25 %", press("ArrowDown"))
        self.assertIn("fit, slope −0.500: time 0.02 s, error 40 %", press("Home", "ArrowDown"))
        self.assertIn("uniform, 1 samples", press("ArrowDown"))
        self.shoot(page, "keys-on-curve")
        self.assertEqual(press("Escape"), "")
        self.assertFalse(page.locator(".plot .tip").first.is_visible())

    def test_what_is_left_out_is_said(self):
        self.assertIn("1 point of 34 is left out", self.open().locator(".plot figcaption").first.inner_text())

    def test_bars_say_what_they_count(self):
        page = self.open("compare.html")
        bars = page.locator(".plot .wide rect[fill='#0072B2']")
        # All pixels of the upper half are 10 % too bright, those of the lower half equal.
        self.assertEqual(bars.count(), 1)
        bars.first.scroll_into_view_if_needed()
        page.mouse.move(*center(bars.first))
        self.assertIn("5000 pixels", page.locator(".plot .tip").inner_text())


class Sliders(Browser):
    """Before and after."""

    RED, BLUE = (220, 30, 30), (30, 60, 220)

    def pixel(self, page, share):
        """The colour at a share of the picture's width."""
        box = page.locator(".slider .pictures").bounding_box()
        clip = {"x": box["x"] + share * box["width"] - 1, "y": box["y"] + box["height"] / 2, "width": 2, "height": 2}
        return Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB").getpixel((0, 0))

    def opened(self, **options):
        page = self.open(**options)
        page.locator(".slider").scroll_into_view_if_needed()
        return page

    def test_mouse(self):
        page = self.opened()
        self.assertEqual((self.pixel(page, 0.25), self.pixel(page, 0.75)), (self.RED, self.BLUE))
        box = page.locator(".slider .pictures").bounding_box()
        x = lambda share: box["x"] + share * box["width"]
        y = box["y"] + box["height"] / 2
        page.mouse.move(x(0.5), y)
        page.mouse.down()
        page.mouse.move(x(0.9), y, steps=4)
        self.assertEqual((self.pixel(page, 0.85), self.pixel(page, 0.95)), (self.RED, self.BLUE))
        page.mouse.up()
        page.mouse.move(x(0.2), y)
        self.assertEqual(self.pixel(page, 0.85), self.RED)

    def test_keyboard(self):
        page = self.opened()
        place = page.locator(".slider input")
        place.focus()
        page.keyboard.press("Home")
        self.assertEqual((self.pixel(page, 0.05), self.pixel(page, 0.95)), (self.BLUE, self.BLUE))
        page.keyboard.press("End")
        self.assertEqual((self.pixel(page, 0.05), self.pixel(page, 0.95)), (self.RED, self.RED))
        for _ in range(3):
            page.keyboard.press("PageDown")
        self.shoot(page, "slider-by-keyboard")
        self.assertEqual(place.get_attribute("aria-valuetext"), "70 % red, 30 % blue")
        self.assertEqual((self.pixel(page, 0.65), self.pixel(page, 0.75)), (self.RED, self.BLUE))
        page.keyboard.press("ArrowLeft")
        self.assertEqual(place.input_value(), "69.5")

    def test_touch(self):
        page = self.opened(size=PHONE, has_touch=True)
        box = page.locator(".slider .pictures").bounding_box()
        page.touchscreen.tap(box["x"] + 0.8 * box["width"], box["y"] + box["height"] / 2)
        self.assertEqual((self.pixel(page, 0.7), self.pixel(page, 0.9)), (self.RED, self.BLUE))

    def test_other_pictures_and_zoom(self):
        page = self.opened()
        page.get_by_label("Picture on the left").select_option("blue")
        page.get_by_label("Picture on the right").select_option("ramp")
        self.assertEqual(self.pixel(page, 0.25), self.BLUE)
        red, green, blue = self.pixel(page, 0.75)
        # 255 · 240 / 319 and 255 · 90 / 179.
        self.assertTrue(abs(red - 192) <= 3 and abs(green - 128) <= 3 and blue == 90, (red, green, blue))
        page.get_by_label("Zoom").select_option("400 %")
        self.assertEqual(page.locator(".slider .pictures").bounding_box()["width"], 4 * 320)
        self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), DESKTOP[0])


class Maps(Browser):
    """Heat maps."""

    def point_at(self, page, map_index, x, y):
        """Points at the middle of a pixel; what is read there."""
        figure = page.locator(".map").nth(map_index)
        picture = figure.locator("img")
        picture.scroll_into_view_if_needed()
        box = picture.bounding_box()
        page.mouse.move(box["x"] + (x + 0.5) / 320 * box["width"], box["y"] + (y + 0.5) / 180 * box["height"])
        readout = figure.locator(".readout")
        page.wait_for_function("(each) => /at /.test(each.textContent)", arg=readout.element_handle())
        return readout

    def test_the_pointer_reads_the_value(self):
        page = self.open()
        # 100 % at the middle, a tenth each 60 pixels.
        for x, y, text in [(160, 90, "100 % at 160, 90"), (220, 90, "10 % at 220, 90"), (0, 0, "not finite at 0, 0"), (1, 0, "0 % at 1, 0")]:
            readout = self.point_at(page, 0, x, y)
            page.wait_for_function("([each, text]) => each.textContent === text", arg=[readout.element_handle(), text], timeout=30000)
        readout = self.point_at(page, 1, 37, 130)
        self.assertEqual(readout.inner_text(), "2037 at 37, 130")
        self.shoot(page, "map-hover")

    def test_keys_go_from_pixel_to_pixel(self):
        page = self.open()
        stage, readout = page.locator(".map .stage").nth(1), page.locator(".map .readout").nth(1)
        page.keyboard.press("Shift")
        stage.focus()
        for keys, text in [([], "1160 at 160, 90"), (["ArrowRight", "ArrowRight"], "1162 at 162, 90"),
                           (["Shift+ArrowDown", "ArrowUp"], "1162 at 162, 105"), (["Shift+ArrowDown"], "2162 at 162, 121")]:
            for key in keys:
                page.keyboard.press(key)
            page.wait_for_function("([each, text]) => each.textContent === text", arg=[readout.element_handle(), text], timeout=30000)

    def test_layers_of_the_files_are_shown(self):
        page = self.open("compare.html")
        names = page.locator(".map h3").all_inner_texts()
        self.assertEqual(names[:2], ["Error (%)", "FLIP"])
        self.assertIn("Estimated error of shot.exr (%)", names)
        self.assertIn("Samples of shot.exr", names)
        self.assertIn("Time of each pixel of shot.exr (µs)", names)


class Tables(Browser):
    """Sorting."""

    def test_columns_sort(self):
        page = self.open()
        table = page.locator("table.sortable").first
        names = lambda: [cell.inner_text() for cell in table.locator("tbody th").all()]
        head = lambda text: table.locator("th", has=page.get_by_role("button", name=text))
        self.assertEqual(names(), ["cornell", "glass", "foliage", "window room"])
        head("time (s)").locator("button").click()
        self.assertEqual(names(), ["foliage", "cornell", "glass", "window room"])
        self.assertEqual(head("time (s)").get_attribute("aria-sort"), "ascending")
        self.shoot(page, "sorted")
        page.keyboard.press("Enter")
        self.assertEqual(names(), ["window room", "glass", "cornell", "foliage"])
        self.assertEqual(head("time (s)").get_attribute("aria-sort"), "descending")
        # Not a number stands last either way.
        for expected in (["window room", "cornell", "foliage", "glass"], ["foliage", "cornell", "window room", "glass"]):
            head("error (%)").locator("button").click()
            self.assertEqual(names(), expected)
        self.assertIsNone(head("time (s)").get_attribute("aria-sort"))
        head("scene").locator("button").click()
        self.assertEqual(names(), ["cornell", "foliage", "glass", "window room"])

    def test_files_can_be_saved(self):
        page = self.open()
        links = page.locator(".save a")
        self.assertEqual(links.count(), 3 + 1 + 3)
        with page.expect_download() as download:
            page.get_by_role("link", name="Save Scenes as CSV").click()
        text = open(download.value.path(), encoding="utf-8", newline="").read()
        self.assertEqual(text.splitlines()[1], "cornell,9.5,2")
        self.assertEqual(download.value.suggested_filename, "scenes.csv")
