// WebKit of a system without a language (LANG=C) calls it "C", which is no tag of a language: uPlot, which asks Intl for it when it is
// read, would fail, and no curve would be drawn. Imported before uPlot.
try {
  Intl.getCanonicalLocales(navigator.language);
} catch {
  Object.defineProperty(navigator, 'language', { value: 'en', configurable: true });
}
