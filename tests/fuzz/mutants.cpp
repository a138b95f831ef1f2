// SPDX-License-Identifier: Apache-2.0
// Mutated files over all readers: mutants [COUNT [SEED]]. Each is accepted or refused by an
// Error, within 2 s of processor time and 1 GiB of memory.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <random>

#include "tests/fuzz/readers.h"

namespace thew::tests {
namespace {

int wanted = 1000;
unsigned seed = 1;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> corpus_of(const char* reader) {
  std::vector<fs::path> files;
  for (const auto& entry :
       fs::directory_iterator(fs::path(THEW_SOURCE_DIR "/tests/fuzz/corpus") / reader)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const fs::path& file : files) corpus.push_back(bytes_of(file));
  return corpus;
}

// Not std::uniform_int_distribution, whose numbers differ between libraries.
struct Random {
  std::mt19937_64 engine;
  size_t below(size_t count) { return count == 0 ? 0 : engine() % count; }
};

std::string mutate(const std::vector<std::string>& corpus, Random& random) {
  constexpr std::array kWords = {"-1",   "1e999",     "nan", "inf", "0",  "4294967296", "\"",
                                 "[[[[", "../../etc", "\n",  "<a>", "{}", "1e-320",     "\xff\xfe"};
  std::string bytes = corpus[random.below(corpus.size())];
  for (size_t changes = 1 + random.below(4); changes > 0; --changes) {
    const size_t at = random.below(bytes.size() + 1);
    const size_t length = random.below(std::min<size_t>(64, bytes.size() - at) + 1);
    switch (random.below(8)) {
      case 0:
        if (at < bytes.size()) bytes[at] ^= static_cast<char>(1 << random.below(8));
        break;
      case 1:
        if (at < bytes.size()) bytes[at] = static_cast<char>(random.engine());
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 4:
        bytes.resize(at);
        break;
      case 5:
        bytes.replace(at, length, kWords[random.below(kWords.size())]);
        break;
      case 6: {  // the tail of another
        const std::string& other = corpus[random.below(corpus.size())];
        bytes.replace(at, bytes.npos, other.substr(random.below(other.size() + 1)));
        break;
      }
      default: {  // a number of the file's own, much larger
        const size_t digit = bytes.find_first_of("123456789", at);
        if (digit != bytes.npos) bytes.insert(digit, 1 + random.below(12), '9');
        break;
      }
    }
  }
  return bytes;
}

double processor_seconds() {
  double seconds = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(who, &used);
    for (const timeval& t : {used.ru_utime, used.ru_stime}) seconds += t.tv_sec + 1e-6 * t.tv_usec;
  }
  return seconds;
}

long largest_kib() {
  rusage self{}, children{};
  getrusage(RUSAGE_SELF, &self);
  getrusage(RUSAGE_CHILDREN, &children);
  return std::max(self.ru_maxrss, children.ru_maxrss);
}

class Mutants : public testing::TestWithParam<int> {
 protected:
  Mutants() { prepare_folder(folder_); }
  ~Mutants() override { fs::remove_all(folder_); }

  const fs::path folder_ =
      fs::path(testing::TempDir()) / ("thew_mutants_" + std::to_string(getpid()));
};

TEST_P(Mutants, AreReadOrRefused) {
  const Reader reader = static_cast<Reader>(GetParam());
  const std::vector<std::string> corpus = corpus_of(kReaders[GetParam()]);
  ASSERT_GE(corpus.size(), 2u);
  // A file that is read in a child costs more.
  constexpr std::array kPermille = {250, 250, 120, 130, 120, 50, 80};
  const int count = wanted * kPermille[GetParam()] / 1000;
  Random random{std::mt19937_64(seed)};
  int accepted = 0;
  double slowest = 0.0;
  for (int i = 0; i < count; ++i) {
    const std::string bytes = mutate(corpus, random);
    const double begin = processor_seconds();
    accepted += accepts(reader, folder_, bytes);
    const double seconds = processor_seconds() - begin;
    slowest = std::max(slowest, seconds);
    if (seconds > 2.5) {
      put_bytes(fs::path(testing::TempDir()) / "thew_slow_mutant", bytes);
      ADD_FAILURE() << "mutant " << i << " took " << seconds << " s; see thew_slow_mutant";
    }
  }
  std::printf("%s: %d mutants, %d accepted, slowest %.2f s, at most %ld MiB\n",
              kReaders[GetParam()], count, accepted, slowest, largest_kib() >> 10);
  EXPECT_LT(largest_kib(), 1l << 20);
  EXPECT_LT(accepted, count);
}

TEST_P(Mutants, TheCorpusIsReadAsItIs) {
  const Reader reader = static_cast<Reader>(GetParam());
  const std::vector<std::string> corpus = corpus_of(kReaders[GetParam()]);
  int accepted = 0;
  for (const std::string& bytes : corpus) accepted += accepts(reader, folder_, bytes);
  std::printf("%s: %d of %zu accepted\n", kReaders[GetParam()], accepted, corpus.size());
  EXPECT_GT(accepted, 1);
}

INSTANTIATE_TEST_SUITE_P(Of, Mutants, testing::Range(0, static_cast<int>(std::size(kReaders))),
                         [](const auto& info) { return std::string(kReaders[info.param]); });

}  // namespace
}  // namespace thew::tests

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) thew::tests::wanted = std::atoi(argv[1]);
  if (argc > 2) thew::tests::seed = static_cast<unsigned>(std::atoi(argv[2]));
  return RUN_ALL_TESTS();
}
