// Searches the sections of the manual for all words; the index is a script beside the pages.
(function () {
  "use strict";
  var field = document.getElementById("search");
  var found = document.getElementById("found");
  var article = document.querySelector("article");
  var root = document.body.dataset.root;
  var most = 20, around = 70;

  function plain(text) {
    return text.normalize("NFD").replace(/[\u0300-\u036f]/g, "").toLowerCase();
  }

  function excerpt(text, word) {
    var place = Math.max(0, plain(text).indexOf(word) - around);
    var piece = text.slice(place, place + 3 * around);
    return (place ? "… " : "") + piece + (place + 3 * around < text.length ? " …" : "");
  }

  function line(entry, word) {
    var item = document.createElement("div");
    var link = document.createElement("a");
    link.href = root + "/" + entry.u;
    link.textContent = entry.p === entry.t ? entry.t : entry.p + ": " + entry.t;
    var text = document.createElement("p");
    text.textContent = excerpt(entry.x, word);
    item.append(link, text);
    return item;
  }

  function show() {
    var words = plain(field.value).split(/\s+/).filter(Boolean);
    var isSearched = words.join("").length > 1;
    found.hidden = !isSearched;
    article.hidden = isSearched;
    found.replaceChildren();
    if (!isSearched) { return; }
    var hits = manualIndex.filter(function (entry) {
      var text = plain(entry.t + " " + entry.x);
      return words.every(function (word) { return text.includes(word); });
    });
    hits.sort(function (a, b) {
      return plain(b.t).includes(words[0]) - plain(a.t).includes(words[0]);
    });
    hits.slice(0, most).forEach(function (entry) { found.append(line(entry, words[0])); });
    if (!hits.length) { found.textContent = found.dataset.nothing; }
  }

  field.addEventListener("input", show);
  window.addEventListener("hashchange", function () { field.value = ""; show(); });
  show();
})();
