# Module dependencies for make, and the layer gate: fails on a file that uses a module of a higher layer.
# With -v strict=1 also on a file that is not named after its module.
# usage: awk -v b=FOLDER [-v u=FOLDER_OF_TESTS] -f depend.awk src/*/*.f90 [verification/unit/*/*.pf] > depend.mk
BEGIN {
  n = split("base math deck materials elements model geometry algebra contact input solution output commands main test", order, " ")
  for (i = 1; i <= n; i++) level[order[i]] = i
}
FNR == 1 {
  n = split(FILENAME, part, "/"); object = part[n]; sub(/\.f90$/, "", object)
  layer = sub(/\.pf$/, "", object) ? "test" : part[n - 1]; if (!(layer in level)) complain("unknown layer '" layer "'")
  object_of[FILENAME] = object; layer_of[FILENAME] = layer
  level_of[FILENAME] = level[layer]
}
{
  line = tolower($0); gsub(/'[^']*'|"[^"]*"/, "", line); sub(/!.*/, "", line)
  count = split(line, statement, ";")
  for (i = 1; i <= count; i++) {
    s = statement[i]; gsub(/[,:()]/, " ", s); fields = split(s, word, " ")
    if (word[1] == "module" && fields == 2 && word[2] != "procedure") define(word[2])
    else if (word[1] == "submodule") { parent[object] = word[2]; uses[FILENAME, ++used[FILENAME]] = word[2] }
    else if (word[1] == "use") uses[FILENAME, ++used[FILENAME]] = (word[2] == "intrinsic") ? "" : word[2]
  }
}
function complain(text) { print FILENAME ": " text > "/dev/stderr"; failed = 1 }
function define(name) {
  if (name in home) complain("module " name " is also in " home[name])
  if (strict && index(object, name) != 1) complain("holds module " name ": a file is named after its module")
  home[name] = FILENAME
}
END {
  for (file in object_of) for (i = 1; i <= used[file]; i++) {
    name = uses[file, i]
    if (!(name in home) || home[name] == file) continue
    if (level_of[file] < level_of[home[name]]) {
      FILENAME = file; complain("uses " name " from a higher layer (" layer_of[home[name]] ")")
    }
    suffix = (parent[object_of[file]] == name) ? ".o" : ".mod"
    print (layer_of[file] == "test" ? u : b) "/" object_of[file] ".o: " b "/" (suffix == ".o" ? object_of[home[name]] : name) suffix
    print b "/" name ".mod: " b "/" object_of[home[name]] ".o"
  }
  exit failed
}
