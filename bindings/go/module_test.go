package cylfuse

import (
	"fmt"
	"os"
	"os/exec"
	"path/filepath"
	"strings"
	"testing"
)

// The programs of users, each a module of its own.

// blocks are the blocks of code of one language in the README.
func blocks(t *testing.T, language string) []string {
	readme, err := os.ReadFile("README.md")
	must(t, err)
	found := strings.Split(string(readme), "```"+language+"\n")[1:]
	for i, text := range found {
		found[i], _, _ = strings.Cut(text, "```")
	}
	return found
}

// run runs commands in a folder, with these environment variables besides those of the test.
func run(t *testing.T, folder, commands string, environment ...string) (string, error) {
	t.Helper()
	command := exec.Command("bash", "-e", "-c", commands)
	command.Dir = folder
	command.Env = append(append(os.Environ(), "GOFLAGS=", "CGO_LDFLAGS="), environment...)
	output, err := command.CombinedOutput()
	return string(output), err
}

// TestReadme takes the module as it is published, which CYLFUSE_GO_MODULE names: it must link the library inside.
func TestReadme(t *testing.T) {
	module := os.Getenv("CYLFUSE_GO_MODULE")
	if module == "" || testing.Short() {
		t.Skip("CYLFUSE_GO_MODULE, the folder of the published module, is not set: test.sh lays it out")
	}
	programs, commands := blocks(t, "go"), blocks(t, "sh")[0]
	want := []string{"radius 0.500000\n", "radius 0.0400, length 0.100, warnings: \n",
		"radius 0.10, sure: true\n"}
	if len(programs) != len(want) {
		t.Fatalf("%d programs in the README", len(programs))
	}
	if before, _, _ := strings.Cut(programs[0], "cylfuse.FitPoints"); strings.Count(before, "\n") >= 10 {
		t.Errorf("the fit comes after line 10:\n%s", programs[0])
	}
	for i, program := range programs {
		// Paths may have blanks and more letters than ASCII has.
		beside := filepath.Join(t.TempDir(), "Maße einer Röhre")
		folder := filepath.Join(beside, "pipe")
		must(t, os.MkdirAll(folder, 0o700))
		must(t, os.Symlink(module, filepath.Join(beside, "cylfuse-go")))
		must(t, os.WriteFile(filepath.Join(folder, "main.go"), []byte(program), 0o600))
		for _, commands := range []string{commands, "go vet .", "go mod vendor; go run ."} {
			output, err := run(t, folder, commands)
			if err != nil || !strings.HasSuffix(output, want[i]) && commands != "go vet ." {
				t.Fatalf("%s\n%v\n%s", commands, err, output)
			}
		}
	}
}

func TestAnotherLibrary(t *testing.T) {
	if testing.Short() {
		t.Skip("builds programs")
	}
	symbols, err := os.ReadFile("../../tests/data/symbols.txt")
	must(t, err)
	here, err := os.Getwd()
	must(t, err)
	program := "package main\n\nimport (\n\t\"cylfuse\"\n\t\"fmt\"\n)\n\n" +
		"func main() {\n\t_, err := cylfuse.NewFitter()\n\tfmt.Print(err)\n}\n"
	for want, library := range map[string]string{
		"cylfuse: the library has version 0.0.9, this package needs at least 0.2.0: install the library that belongs to " +
			"the package": "#define ABI 1\n#define NUMBER 9\n",
		"cylfuse: the library has version 2 of the binary interface, this package needs 1: install the library that " +
			"belongs to the package": "#define ABI 2\n#define NUMBER 65536\n",
	} {
		folder := t.TempDir()
		library += "int cylfuse_abi_version(void) { return ABI; }\nint cylfuse_version_number(void) { return NUMBER; }\n" +
			"const char *cylfuse_version_string(void) { return \"0.0.9\"; }\n"
		for _, symbol := range strings.Fields(string(symbols)) {
			if !strings.Contains(library, symbol+"(") {
				library += fmt.Sprintf("int %s(void) { return 0; }\n", symbol)
			}
		}
		must(t, os.WriteFile(filepath.Join(folder, "library.c"), []byte(library), 0o600))
		must(t, os.WriteFile(filepath.Join(folder, "main.go"), []byte(program), 0o600))
		_, err := run(t, folder, "mkdir lib; cc -shared -fPIC library.c -o lib/libcylfuse.so; rm library.c; go mod init other")
		must(t, err)
		output, err := run(t, folder, `go mod edit -require=cylfuse@v0.0.0 "-replace=cylfuse=$MODULE"; go run -tags cylfuse_system .`,
			"MODULE="+here, "CGO_LDFLAGS=-L"+folder+"/lib -Wl,-rpath,"+folder+"/lib")
		if err != nil || output != want {
			t.Errorf("%v, %s\nis not: %s", err, output, want)
		}
	}
}
